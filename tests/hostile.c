/* Random calls of a compiled model, many with values that no motion has; read after the model's own text. */

#include <stdio.h>

static double strange(void)
{
    const double size = uniform();
    return size < 0.12 ? odd[(int)(50.0 * size)] : (uniform() - 0.5) * pow(10.0, 8.0 * uniform() - 4.0);
}

int main(void)
{
    static const double p[] = {PARAMETERS}, gains[] = {GAINS}, data[] = {DATA};
    static const int pieces[2] = {1, 1}, sampled[2] = {1, 1};
    const double times[3] = {0.0, 1e-4, 3e-4};
    double k[CONSTANTS + 1], x[ALL], u[INPUTS + 1], du[RATES + 1], f[ALL], j[STATES * STATES];
    double rows[2 * ALL], unit[ALL], given[3 * (INPUTS + 1)] = {0.0}, moving_by[3 * (INPUTS + 1)] = {0.0};
    double in[GOALS + SIGNALS + MEMORY + 1], out[COMMANDS + MEMORY + 1], s[SIGNALS + 1];
    int finite = 0, reached = 0;
    constants(p, k);
    for (int n = 0; n < CALLS; n++) {
        for (int i = 0; i < ALL; i++) {
            x[i] = strange();
            unit[i] = 1e-8;
        }
        for (int i = 0; i < INPUTS; i++) {
            u[i] = strange();
        }
        for (int i = 0; i < RATES; i++) {
            du[i] = strange();
        }
        rates_at(p, k, x, u, du, f);
        powers_at(p, k, x, u, du, f + STATES);
        slopes_at(p, k, x, u, du, j);
        signals_at(p, k, x, u, du, s);
        for (int i = 0; i < GOALS + SIGNALS + MEMORY; i++) {
            in[i] = strange();
        }
        controlled(gains, data, in, out);
        finite += isfinite(f[0]) ? 1 : 0;
        if (n % 2000 == 0) {
            double width = 1e-5;
            for (int i = 0; i < 3 * INPUTS; i++) {
                given[i] = 10.0 * (uniform() - 0.5);
            }
            for (int i = 0; i < ALL; i++) {
                x[i] = n % 4000 ? uniform() - 0.5 : x[i];
            }
            reached += advance(p, k, 2, times, given, moving_by, x, 1e-8, unit, &width, rows) ? 0 : 1;
            double goals[2 * GOALS + 1] = {0.0}, seen[2 * INPUTS + 1] = {0.0}, seen_rates[2 * RATES + 1] = {0.0};
            double memory[MEMORY + 1] = {0.0}, commands[COMMANDS + 1] = {0.0}, held[2 * COMMANDS + 1];
            const double at[4] = {0.0, 1e-4, 1e-4, 3e-4};
            double fed[4 * (INPUTS + 1)] = {0.0}, fed_by[4 * (INPUTS + 1)] = {0.0};
            for (int i = 0; i < 2 * GOALS; i++) {
                goals[i] = strange();
            }
            march(p, k, gains, data, 2, pieces, sampled, goals, seen, seen_rates, at, fed, fed_by, x, memory, commands,
                  held, 1e-8, unit, &width, rows);
        }
    }
    printf("%d %d\n", finite, reached);
    return 0;
}

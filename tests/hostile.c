/* Random calls of a compiled model, many with values that no motion has; read after the model's own text. */

#include <stdio.h>

static double strange(void)
{
    const double size = uniform();
    return size < 0.12 ? odd[(int)(50.0 * size)] : (uniform() - 0.5) * pow(10.0, 8.0 * uniform() - 4.0);
}

int main(void)
{
    static const double p[] = {PARAMETERS};
    const double times[3] = {0.0, 1e-4, 3e-4};
    double k[CONSTANTS + 1], x[ALL], u[INPUTS + 1], du[RATES + 1], f[ALL], j[STATES * STATES];
    double rows[2 * ALL], unit[ALL], given[3 * (INPUTS + 1)] = {0.0}, moving_by[3 * (INPUTS + 1)] = {0.0};
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
        }
    }
    printf("%d %d\n", finite, reached);
    return 0;
}

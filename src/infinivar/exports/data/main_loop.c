/* Runs the closed loop for 1 s with the goal, or the user, from which it starts, and prints time and states every 10 ms:
   cc -O2 -std=c99 NAME_main.c -lm */

#include <stdio.h>

#include "NAME.c"

int main(void)
{
    double p[GIVEN], k[CONSTANTS + 1], x[ALL] = {0.0}, u[2 * (INPUTS + RATES) + 1], du[2 * INPUTS + 1] = {0.0};
    double in[GOALS + SIGNALS], memory[MEMORY + 1], out[COMMANDS], absolute[ALL], width = 1e-5, printed = 0.0;
    start(x, u, p);
    constants(p, k);
    start_control(in, memory);
    for (int i = 0; i < ALL; i++) {
        absolute[i] = 1e-8;
    }
    for (int sample = 0;; sample++) {
        const double times[] = {sample * period, (sample + 1) * period};
        if (times[0] > printed - 1e-6 * period) {
            printf("%.3f", times[0]);
            for (int i = 0; i < STATES; i++) {
                printf(", %.12g", x[i]);
            }
            printf("\n");
            printed += 0.01;
        }
        if (times[0] > 1.0 - 1e-6 * period) {
            return 0;
        }
        if (sample >= BEGUN) {
            in[0] = times[0];
            signals_at(p, k, x, u, du, in + GOALS); /* inputs are held: du is 0 */
            control(in, memory, out);
            for (int i = 0; i < COMMANDS; i++) {
                u[commanded[i]] = out[i];
            }
        }
        memcpy(u + INPUTS, u, INPUTS * sizeof *u); /* inputs at the end of a step: held */
        if (advance(p, k, 1, times, u, du, x, 1e-8, absolute, &width, x)) {
            return 1;
        }
    }
}

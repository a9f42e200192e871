/* Runs the plant for 1 s and prints time and states every 10 ms: cc -O2 -std=c99 NAME_main.c -lm */

#include <stdio.h>

#include "NAME.c"

int main(void)
{
    double p[GIVEN], k[CONSTANTS + 1], x[ALL] = {0.0}, u[2 * (INPUTS + RATES) + 1], du[2 * INPUTS + 1] = {0.0};
    double absolute[ALL], width = 1e-4;
    start(x, u, p);
    constants(p, k);
    memcpy(u + INPUTS, u, INPUTS * sizeof *u); /* inputs at the end of a step: held */
    for (int i = 0; i < ALL; i++) {
        absolute[i] = 1e-8;
    }
    for (int step = 0; step <= 100; step++) {
        const double times[] = {0.01 * (step - 1), 0.01 * step};
        if (step && advance(p, k, 1, times, u, du, x, 1e-8, absolute, &width, x)) {
            return 1;
        }
        printf("%.2f", times[1]);
        for (int i = 0; i < STATES; i++) {
            printf(", %.12g", x[i]);
        }
        printf("\n");
    }
    return 0;
}

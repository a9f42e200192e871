
/* One sample of the controller.

   inputs: the goal (time since the begin, position, speed, acceleration, current for a planned force) and the signals that
   `signals_at` writes; memory: what it remembers, replaced; outputs: what it commands until the next sample, after `period`. */
void control(const double *inputs, double *memory, double *outputs)
{
    double in[GOALS + SIGNALS + MEMORY + 1], out[COMMANDS + MEMORY + 1];
    memcpy(in, inputs, (GOALS + SIGNALS) * sizeof *in);
    memcpy(in + GOALS + SIGNALS, memory, MEMORY * sizeof *in);
    controlled(NULL, control_data, in, out);
    memcpy(outputs, out, COMMANDS * sizeof *out);
    memcpy(memory, out + COMMANDS, MEMORY * sizeof *out);
}

/* What the controller starts from: the goal, its time first, and its memory. */
void start_control(double *goal, double *memory)
{
    memset(goal, 0, GOALS * sizeof *goal);
    memcpy(goal + 1, start_goal, SHOWN * sizeof *goal);
    memcpy(memory, start_memory, MEMORY * sizeof *memory);
}

/* Time between samples. [s] */
double control_period(void)
{
    return period;
}

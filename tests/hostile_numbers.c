/* Numbers for random calls: uniform ones, and some that no motion has. */

#include <math.h>

static unsigned long long seed = 88172645463325252ULL;

static double uniform(void)
{
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return (double)(seed >> 11) / 9007199254740992.0;
}

static const double odd[] = {NAN, INFINITY, -INFINITY, -1e300, 1e-320, 0.0};


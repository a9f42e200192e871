
/* Inputs of a law, its results, ends of speed and force, and a map, first index force, second index speed. */
enum { CELLS = 200 };
double given[16], found[5], plane[4];
float efficiency[CELLS * CELLS], loss[CELLS * CELLS];
unsigned char limit[CELLS * CELLS];

void point(int drive)
{
    if (drive == 0) {
        law0(given, found);
    } else {
        law1(given, found);
    }
}

void map(int drive, int count)
{
    for (int i = 0; i < count; i++) {
        given[1] = plane[2] + (plane[3] - plane[2]) * (i + 0.5) / count;
        for (int j = 0; j < count; j++) {
            const int cell = i * count + j;
            given[0] = plane[0] + (plane[1] - plane[0]) * (j + 0.5) / count;
            point(drive);
            efficiency[cell] = (float)found[0];
            loss[cell] = (float)found[1];
            limit[cell] = (unsigned char)found[2];
        }
    }
}

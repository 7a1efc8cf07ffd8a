/// What nm_check.cmake must refuse: a heap call, a libm call and data that changes.
#include <math.h>
#include <stdlib.h>

int pal_mutant_count;
void* pal_mutant(double x);

void* pal_mutant(double x) {
    pal_mutant_count += 1;
    return malloc((size_t)sin(x));
}

/// What nm_check.cmake must refuse, one rule a build: PAL_MUTANT_HEAP, _STDIO, _LIBM, _DATA or _BSS. Without
/// any it must pass.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

double pal_mutant(double x);

#if defined PAL_MUTANT_DATA
int pal_mutant_word = 1;
#elif defined PAL_MUTANT_BSS
int pal_mutant_word;
#endif

double pal_mutant(double x) {
#if defined PAL_MUTANT_HEAP
    return malloc((size_t)x) != NULL ? 1.0 : 0.0;
#elif defined PAL_MUTANT_STDIO
    return puts("") == EOF ? x : 0.0;
#elif defined PAL_MUTANT_LIBM
    return sin(x);
#elif defined PAL_MUTANT_DATA || defined PAL_MUTANT_BSS
    pal_mutant_word += 1;
    return x * pal_mutant_word;
#else
    return 2.0 * x;
#endif
}

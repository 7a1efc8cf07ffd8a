/// What palpate-falcon-sim --help says.
#pragma once
#include <stdio.h>

/// 0; 1 when it could not be written.
int pal_help(FILE* out);

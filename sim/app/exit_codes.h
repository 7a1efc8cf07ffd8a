/// How palpate-falcon-sim ends, besides 0.
#pragma once

enum { PAL_EXIT_BAD_INPUT = 2, PAL_EXIT_LINK = 3 };

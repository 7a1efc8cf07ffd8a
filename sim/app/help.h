/// What palpate-falcon-sim --help says.
#pragma once

extern const char PAL_HELP[];

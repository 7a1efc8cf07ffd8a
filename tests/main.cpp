// The main of every test program. Compiled once a preset, without sanitizers: instrumented it takes minutes.
#define CATCH_CONFIG_MAIN
#include <catch2/catch.hpp>

/// Writes host/plate/uniform/uniform_table.inc: continuum values of the uniform clamped square at the Lobatto
/// points of [0, 4], [4, 8], [8, 16], [16, 24], flattened (host/plate/uniform/uniform.hpp).
#include <cstdio>

#include "host/plate/uniform/lobatto.hpp"
#include "host/plate/uniform/uniform.hpp"
#include "tests/host/plate/square_series.hpp"

int main() {
    using namespace palpate::plate;
    std::printf("// Written by square-series-table (tests/host/plate/uniform/uniform_table.cpp).\n");
    for (const Interval& interval :
         {Interval{0.0, 4.0}, Interval{4.0, 8.0}, Interval{8.0, 16.0}, Interval{16.0, 24.0}}) {
        std::printf("Values{");
        int column = 0;
        for (const double s : lobatto_points(interval)) {
            const double flat = flattened(truth::uniform_square_compliance(s), s);
            std::printf("%s%.12f,", column++ % 6 == 0 ? "\n    " : " ", flat);
        }
        std::printf("\n},\n");
    }
    return 0;
}

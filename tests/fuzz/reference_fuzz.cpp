// A request to palpate-reference: a plate that can be solved without leaving its arrays, or BadRequest.
#include <cmath>
#include <sstream>

#include "host/plate/reference/request.hpp"
#include "tests/fuzz/input.hpp"

namespace {

using fuzz::require;

fuzz::Reached accepted("request accepted"), founded("with a foundation");

void check(const palpate::reference::Plate& plate) {
    require(plate.nx >= 5 && plate.nx <= 1025 && plate.nz >= 5 && plate.nz <= 1025);
    require(plate.rigidity_n_m.size() == plate.nx * plate.nz);
    require(plate.foundation_n_per_m3.empty() || plate.foundation_n_per_m3.size() == plate.nx * plate.nz);
    require(plate.contact_ix >= 1 && plate.contact_ix <= plate.nx - 2);
    require(plate.contact_iz >= 1 && plate.contact_iz <= plate.nz - 2);
    for (const double x : {plate.size_x_m, plate.size_z_m, plate.depth_m})
        require(x > 0.0 && std::isfinite(x));
    require(plate.poisson > -1.0 && plate.poisson < 0.5);
    accepted.note();
    if (!plate.foundation_n_per_m3.empty()) founded.note();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    std::istringstream in{std::string(fuzz::text_of({data, size}))};
    try {
        check(palpate::reference::read_plate(in));
    } catch (const palpate::reference::BadRequest&) {
    }
    return 0;
}

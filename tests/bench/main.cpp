/// palpate-bench COMMIT [--benchmark_...]: how long things take on this machine. Run from the project's root.
#include <unistd.h>

#include <array>
#include <cmath>
#include <exception>
#include <fstream>
#include <iostream>
#include <map>
#include <string>

#include "host/app/build_info.hpp"
#include "tests/bench/markdown.hpp"
#include "tests/bench/measure.hpp"

namespace {

std::string cpu_model() {
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);) {
        if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
    }
    return "unknown";
}

std::string machine_name() {
    std::array<char, 256> name{};
    return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

std::map<std::string, std::string> titles() {
    return {{"tick", "One tick of the loop, each timed by itself (the period is 1 ms)"},
            {"part", "Parts of a tick, alone"},
            {"session",
             "A whole tick of palpate-loop around a device that answers at once: what measuring costs"},
            {"link", "Between host and loop, in one thread"},
            {"arrival", "What a table costs on arrival: checksum, ranges, limits"},
            {"stiffness",
             "Bunny scene: stiffness of one point, places along the scene's path in turn (CPU time)"},
            {"table", "Bunny scene: one table (CPU time)"},
            {"plate", "Error of the plate's centre compliance against its time (CPU time)"},
            {"cholesky",
             "From a new D to the centre's compliance, against CHOLMOD and Eigen, in turn (CPU time)"},
            {"jacobi",
             "New D to centre compliance: damped Jacobi to an error of 1e-3 against the plate (CPU time)"},
            {"bounds", "A certified bracket, rung by rung, and the factorisation it saves (CPU time)"}};
}

void run(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    const std::string commit = argc > 1 ? argv[1] : "unknown";
    const double clock_s = palpate::bench::clock_cost_s(palpate::bench::Clock::wall);
    const std::string clock_ns = std::to_string(std::lround(1e9 * clock_s));
    benchmark::AddCustomContext("machine", machine_name());
    benchmark::AddCustomContext("cpu_model", cpu_model());
    benchmark::AddCustomContext("compiler", PALPATE_BUILD);
    benchmark::AddCustomContext("commit", commit);
    benchmark::AddCustomContext("clock_ns", clock_ns);

    palpate::bench::register_tick();
    palpate::bench::register_session();
    palpate::bench::register_link();
    palpate::bench::register_stiffness();
    palpate::bench::register_plate();
    palpate::bench::register_cholesky();
    palpate::bench::register_jacobi();
    palpate::bench::register_bounds();

    std::cout << machine_name() << ", " << cpu_model() << ", " << sysconf(_SC_NPROCESSORS_ONLN) << " CPUs, "
              << PALPATE_BUILD << ", commit " << commit << ", clock " << clock_ns
              << " ns (taken off)\nEach figure: median over the repetitions (least .. most of them).\n";
    palpate::bench::Markdown markdown(std::cout, titles());
    benchmark::RunSpecifiedBenchmarks(&markdown);
    benchmark::Shutdown();
}

}  // namespace

int main(int argc, char** argv) {
    try {
        run(argc, argv);
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "palpate-bench: " << error.what() << '\n';
        return 1;
    }
}

/// palpate-reference: slow, independent answers to hold the renderer's plates against.
#include <exception>
#include <iostream>
#include <string>

#include "host/plate/reference/linear.hpp"
#include "host/plate/reference/request.hpp"

namespace {

constexpr const char* HELP = R"(usage: palpate-reference plate < PROBLEM.json

Solves a clamped plate of varying rigidity with Ceres, the contact node held at a depth, and prints
{"compliance_m_per_n": ..., "iterations": ..., "reaction_n": ...}.

keys of the problem:
  size_m               [x, z], sides
  nodes                [nx, nz], 5 to 1025 each, edge nodes included
  rigidity_n_m         nx * nz values, z fastest, positive
  foundation_n_per_m3  nx * nz values, not negative (default: none)
  poisson              in (-1, 0.5) (default 0.2)
  depth_m              of the contact node (default 0.001)
  contact_node         [ix, iz], inside the edge (default: nx/2, nz/2)

exit status: 0 solved, 1 no solution, 2 bad input
)";

}  // namespace

int main(int argc, char** argv) {
    namespace reference = palpate::reference;
    const std::string command = argc == 2 ? argv[1] : "";
    if (command == "--help") {
        std::cout << HELP;
        return 0;
    }
    if (command != "plate") {
        std::cerr << "palpate-reference: expected one command, `plate` (or --help)\n";
        return 2;
    }
    try {
        std::cout << reference::answer_text(reference::solve(reference::read_plate(std::cin))) << '\n';
        return std::cout.flush() ? 0 : 1;
    } catch (const reference::BadRequest& error) {
        std::cerr << "palpate-reference: " << error.what() << '\n';
        return 2;
    } catch (const std::exception& error) {
        std::cerr << "palpate-reference: " << error.what() << '\n';
        return 1;
    }
}

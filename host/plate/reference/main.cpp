/// palpate-reference: slow, independent answers to hold the renderer's plates against.
#include <exception>
#include <iostream>
#include <string>

#include "host/plate/reference/cap.hpp"
#include "host/plate/reference/cholmod.hpp"
#include "host/plate/reference/depth_table.hpp"
#include "host/plate/reference/linear.hpp"
#include "host/plate/reference/request.hpp"
#include "host/plate/reference/shell.hpp"
#include "host/plate/reference/square.hpp"

namespace {

namespace reference = palpate::reference;

constexpr const char* HELP = R"(usage: palpate-reference plate|shell|square|cap|cholmod < PROBLEM.json
       palpate-reference depth-law > host/plate/depth_law_table.inc

Answers from Ceres to hold the renderer's plates against. One point is held at a depth; the answer is the
force that takes. Every edge is clamped: no deflection, no slope.

  plate      small deflections of a rectangle whose rigidity varies from node to node
  shell      large deflections on the same grid, with membrane strains and curvature; without a
             curvature: the von Karman plate
  square     a uniform square shell pressed at its middle, in few elements of high order: where shell
             is 1 % out, 0.1 % in the same time
  cap        a uniform round patch of a sphere, pressed at its middle: milliseconds
  cholmod    what `plate` asks, by CHOLMOD's factorisations, timed (budget_s: seconds for each)
  depth-law  the table of F/(k d) over d/h, flat, convex and concave, from which host/plate/depth_law has
             its constants (a minute)

keys of plate and shell:
  size_m               [x, z], sides
  nodes                [nx, nz], 5 to 1025 each, edge nodes included; odd puts a node in the middle
  rigidity_n_m         E h^3/(12 (1 - nu^2)): one number, or nx * nz, z fastest; positive
  foundation_n_per_m3  one number, or nx * nz, not negative (default: none)
  poisson              in (-1, 0.5) (default 0.2)
  contact_node         [ix, iz], inside the edge (default: nx/2, nz/2)
plate only:
  depth_m              of the contact node (default 0.001)
keys of square and cap:
  side_m | radius_m    of the patch
  rigidity_n_m         one number
  poisson              as above
  elements             4 to 256, along half a side or the radius (default 12 | 64)
shell, square and cap:
  thickness_m          h
  curvature_per_m      [along x, along z], for cap one number; positive: convex, pressed from outside
                       (default 0)
  edge                 "fixed" in its own plane, or "free" there (default "fixed")
  depths_m             list, smallest first: each depth starts from the one before

answers: {"compliance_m_per_n", "iterations", "reaction_n"} from plate; from the others
         {"depths_m", "energy_j", "force_ratio", "iterations", "linear_stiffness_n_per_m", "reaction_n"},
         lists by depth, force_ratio = F/(k d)

A rubber dome of 30 mm radius, 1 mm thick, pressed in by its thickness takes 0.6 of what its first touch
promises:

  echo '{"radius_m": 0.036, "thickness_m": 1e-3, "rigidity_n_m": 8.7e-5, "curvature_per_m": 33.3,
         "depths_m": [1e-4, 1e-3]}' | palpate-reference cap

exit status: 0 solved, 1 no solution, 2 bad input
)";

template <class Body>
std::string pressed_text(const reference::Press<Body>& request) {
    return reference::answer_text(press(request.body, request.depths_m)) + '\n';
}

std::string answer(const std::string& command) {
    if (command == "plate") return answer_text(reference::solve(reference::read_plate(std::cin))) + '\n';
    if (command == "shell") return pressed_text(reference::read_shell(std::cin));
    if (command == "square") return pressed_text(reference::read_square(std::cin));
    if (command == "cap") return pressed_text(reference::read_cap(std::cin));
    if (command == "cholmod") return reference::cholmod_text(std::cin) + '\n';
    if (command == "depth-law") return reference::depth_table_text();
    if (command == "--help") return HELP;
    throw reference::BadRequest(
        "expected one command: plate, shell, square, cap, cholmod or depth-law (or --help)");
}

}  // namespace

int main(int argc, char** argv) {
    try {
        std::cout << answer(argc == 2 ? argv[1] : "");
        return std::cout.flush() ? 0 : 1;
    } catch (const reference::BadRequest& error) {
        std::cerr << "palpate-reference: " << error.what() << '\n';
        return 2;
    } catch (const std::exception& error) {
        std::cerr << "palpate-reference: " << error.what() << '\n';
        return 1;
    }
}

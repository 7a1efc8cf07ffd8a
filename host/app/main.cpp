#include <iostream>
#include <string>

#include "host/app/build_info.hpp"
#include "host/app/child.hpp"
#include "host/app/commands.hpp"
#include "host/app/interrupt.hpp"
#include "host/app/live.hpp"
#include "host/app/scratch.hpp"
#include "host/cloud/cloud.hpp"
#include "host/link/segment.hpp"
#include "host/record/record.hpp"
#ifdef PALPATE_HAS_RIG
#include "host/rig/rig.hpp"
#endif
#include "host/scene/scene.hpp"

namespace {

constexpr const char* FOOTER =
    "Example:\n"
    "  palpate run sim/scenes/bunny.toml            a simulated hand feels a lump in a soft ear\n"
    "  palpate view out/bunny/run.palrec            what it felt\n"
    "\n"
    "Exit codes: 0 done, 1 a verdict failed, 2 bad input, 3 device or link failed, 130 interrupted.";

int run(int argc, char** argv) {
    CLI::App palpate(
        "palpate: feel scanned, thin, soft things through a haptic device, and know how wrong it is.");
    palpate.set_version_flag("--version", std::string("palpate ") + PALPATE_VERSION);
    palpate.require_subcommand(1);
    palpate.footer(FOOTER);
    palpate.failure_message([](const CLI::App*, const CLI::Error& error) {
        return std::string("palpate: ") + error.what() + "; see palpate --help\n";
    });
    std::function<int()> chosen;
    palpate::app::add_run(palpate, chosen);
    palpate::app::add_bench(palpate, chosen);
    palpate::app::add_solve(palpate, chosen);
    palpate::app::add_device(palpate, chosen);
    palpate::app::add_doctor(palpate, chosen);
    palpate::app::add_trace(palpate, chosen);
#ifdef PALPATE_HAS_VIEW
    palpate::app::add_view(palpate, chosen);
#endif
    try {
        palpate.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return palpate.exit(error) == 0 ? 0 : 2;
    }
    return chosen();
}

int complain(const std::exception& error, int code) {
    std::cerr << "palpate: " << error.what() << '\n';
    return code;
}

}  // namespace

int main(int argc, char** argv) {
    try {
        return run(argc, argv);
    } catch (const palpate::scene::Error& error) {
        return complain(error, 2);
    } catch (const palpate::cloud::Error& error) {
        return complain(error, 2);
    } catch (const palpate::record::Error& error) {
        return complain(error, 2);
    } catch (const palpate::app::LiveInputError& error) {
        return complain(error, 2);
    } catch (const palpate::app::ScratchError& error) {
        return complain(error, 2);
#ifdef PALPATE_HAS_RIG
    } catch (const palpate::rig::Error& error) {
        return complain(error, 2);
#endif
    } catch (const palpate::app::Interrupted& error) {
        return complain(error, 130);
    } catch (const palpate::app::ChildError& error) {
        return complain(error, 3);
    } catch (const palpate::link::Error& error) {
        return complain(error, 3);
    } catch (const std::exception& error) {
        return complain(error, 1);
    }
}

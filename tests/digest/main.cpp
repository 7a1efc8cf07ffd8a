/// palpate-digest FOLDER: writes the 2 s sheet scene into FOLDER, runs it in virtual time, prints both
/// digests. For matrix.sh, which compares compilers and levels.
#include <cstdio>
#include <exception>

#include "host/app/run.hpp"
#include "tests/host/app/sheet.hpp"

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fputs("palpate-digest FOLDER: digests of a 2 s run, for comparing builds\n", stderr);
        return 2;
    }
    try {
        using namespace palpate;
        app::Progress quiet(true);
        const app::Prepared prepared = app::prepare(scene::build(test::sheet_scene(argv[1])), quiet);
        const app::RunResult result = app::run_virtual(prepared, {}, quiet);
        std::printf("%s %s\n", result.digest_io.c_str(), result.digest_state.c_str());
    } catch (const std::exception& error) {
        std::fprintf(stderr, "palpate-digest: %s\n", error.what());
        return 1;
    }
    return 0;
}

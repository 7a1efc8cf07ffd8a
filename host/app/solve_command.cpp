#include <unistd.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <memory>
#include <system_error>

#include "host/app/commands.hpp"
#include "host/app/interrupt.hpp"
#include "host/app/solve_answer.hpp"
#include "host/app/solve_document.hpp"
#include "host/app/solve_plot.hpp"
#include "host/record/record.hpp"
#include "host/scene/array_file.hpp"
#include "host/scene/keys.hpp"
#include "host/scene/scene.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;

struct SolveOptions {
    std::string file, out;
    std::vector<std::string> set;
    bool json = false, quiet = false;
};

constexpr const char* SOLVE_FOOTER =
    "Example:\n"
    "  palpate solve sim/scenes/plates/nodule.toml --out out/nodule    beside a stiff spot; map and field\n"
    "  palpate solve nodule.toml --set solver.method=multigrid --json | jq .compliance_m_per_n\n"
    "\n"
    "A plate file needs no more than this; docs/PLATE_FILE.md has every key:\n"
    "  [plate]\n"
    "  size_m = [0.04, 0.04]\n"
    "  poisson = 0.3\n"
    "  [rigidity]\n"
    "  value_n_m = 0.03               # or file = \"rigidity.csv\"\n"
    "\n"
    "Exit codes: 0 done, 1 no number (diverged, not-converged, a guard) or no picture, 2 bad input,\n"
    "130 interrupted.";

std::string command_of(const SolveOptions& options) {
    std::string command = "palpate solve " + options.file;
    for (const std::string& set : options.set) command += " --set " + set;
    return command;
}

/// Where an output goes; empty when it is not asked for. Refused now, before anything is solved, when it
/// cannot go there or would take the place of an input.
fs::path output_path(const SolveOptions& options, const scene::PlateFile& file, const std::string& key,
                     const fs::path& name) {
    if (name.empty()) return {};
    const std::string place = scene::where(file, key);
    const fs::path folder = options.out.empty() ? file.path.parent_path() : fs::path(options.out);
    fs::path path = folder / name;
    const auto fail = [&](const std::string& why) {
        scene::refuse(
            place, path.string() + " cannot be written (" + why + "); choose another " + key + " or --out");
    };
    std::error_code error;
    const fs::path parent = path.parent_path().empty() ? fs::path(".") : path.parent_path();
    fs::create_directories(parent, error);
    if (error) fail(error.message());
    if (access(parent.c_str(), W_OK) != 0) fail(std::generic_category().message(errno));
    if (fs::is_directory(path, error)) fail("it is a directory");
    for (const fs::path& input : {file.path, file.path.parent_path() / file.rigidity.file}) {
        if (fs::exists(path, error) && fs::equivalent(path, input, error)) fail("it is an input");
    }
    return path;
}

/// Writes what was asked for, or notes why not.
void write_files(const scene::PlateFile& file, const SolveAnswer& answer, SolveTold& told) {
    if (answer.deflection_m.size() == 0) {
        const bool solved = answer.compliance.status == plate::Status::solved;
        const std::string why = solved ? "the method gives no deflections" : "there is no solution";
        told.field.missing_why = told.plot.missing_why = why;
        return;
    }
    if (!told.field.path.empty())
        record::write_file(told.field.path, scene::array_bytes(told.field.path, answer.deflection_m));
    if (!told.plot.path.empty())
        told.plot.missing_why = draw_deflection(told.plot.path, file, answer.deflection_m);
}

/// What went wrong, on stderr; the exit code.
int judge(const scene::PlateFile& file, const SolveAnswer& answer, const SolveTold& told) {
    const plate::Compliance& c = answer.compliance;
    if (c.status != plate::Status::solved) {
        std::cerr << "palpate: " << file.path.string() << ": " << plate::name_of(c.status) << ' '
                  << plate::name_of(c.method) << " after " << c.iterations
                  << " sweeps; another solver.method, such as auto, may do\n";
        return 1;
    }
    int code = 0;
    for (const SolveFile* asked : {&told.field, &told.plot}) {
        if (asked->path.empty() || asked->missing_why.empty()) continue;
        std::cerr << "palpate: " << asked->path.string() << " was not made: " << asked->missing_why << '\n';
        code = 1;
    }
    return code;
}

/// With --json a document on stdout and words on stderr; else words on stdout, or with --quiet the compliance
/// alone.
void say(const SolveOptions& options, const report::Json& document) {
    if (options.json) {
        if (!options.quiet) std::cerr << solve_page(document);
        std::cout << document.dump(2) << '\n';
    } else if (!options.quiet) {
        std::cout << solve_page(document);
    } else if (document["compliance_m_per_n"].is_number()) {
        std::cout << scene::number_text(document["compliance_m_per_n"]) << '\n';
    }
    if (!std::cout.flush()) throw std::runtime_error("stdout cannot be written");
}

int solve(const SolveOptions& options) {
    catch_interrupts();
    const scene::PlateFile file = scene::load_plate(options.file, options.set);
    SolveTold told{.command = command_of(options),
                   .started_utc = record::utc_text(std::time(nullptr)),
                   .field = {output_path(options, file, "output.field", file.output.field), ""},
                   .plot = {output_path(options, file, "output.plot", file.output.plot), ""}};
    SolveAnswer answer;
    try {
        answer = solve_answer(file);
    } catch (const Interrupted& error) {
        std::cerr << "palpate: " << error.what() << std::endl;
        std::_Exit(130);  // the solver's thread is still at work: nothing of it may be taken down
    }
    write_files(file, answer, told);
    say(options, solve_document(file, answer, told));
    return judge(file, answer, told);
}

}  // namespace

void add_solve(CLI::App& palpate, std::function<int()>& chosen) {
    auto options = std::make_shared<SolveOptions>();
    CLI::App* command =
        palpate.add_subcommand("solve", "how far a plate of one's own gives way, and how sure that is");
    command->add_option("plate", options->file, "plate file (docs/PLATE_FILE.md)")->required();
    command->add_option("--out", options->out,
                        "folder of output.field and output.plot (that of the plate file)");
    command->add_option("--set", options->set, "section.key=value: any key of the plate file")
        ->allow_extra_args(false);
    command->add_flag("--json", options->json, "print a document on stdout, the words on stderr");
    command->add_flag("--quiet", options->quiet, "no words; without --json the compliance in m/N alone");
    command->footer(SOLVE_FOOTER);
    command->callback([options, &chosen] { chosen = [options] { return solve(*options); }; });
}

}  // namespace palpate::app

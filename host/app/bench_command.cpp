#include <unistd.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <fstream>
#include <iostream>
#include <memory>
#include <sstream>

#include "host/app/build_info.hpp"
#include "host/app/child.hpp"
#include "host/app/commands.hpp"
#include "host/app/interrupt.hpp"
#include "host/app/progress.hpp"
#include "host/app/scratch.hpp"
#include "host/record/record.hpp"
#include "host/report/gnuplot.hpp"
#include "host/study/extreme_results.hpp"
#include "host/study/machine.hpp"
#include "host/study/plate_results.hpp"
#include "host/study/text.hpp"

namespace palpate::app {
namespace {

namespace fs = std::filesystem;
using study::Json;

struct BenchOptions {
    std::string out;
    std::vector<std::string> fields, groups, methods;
    std::vector<Eigen::Index> nodes;
    double budget_s = 0.0;
    bool full = false, json = false, quiet = false;
};

constexpr const char* PLATE_FOOTER =
    "Examples:\n"
    "  palpate bench plate                                          everything, some two minutes\n"
    "  palpate bench plate --fields hyperbolic,random --nodes 17,33 --budget 0.05\n"
    "\n"
    "Writes results.csv, results.json, results.md and pareto.png. Error: of the centre's compliance about "
    "the\n"
    "continuum; the reference's own error stands beside it. Time: from a new D to the compliance, all else "
    "made\n"
    "ready; median and quartiles. Memory: what malloc has in use with the method ready and asked, less "
    "before.\n"
    "palpate-reference beside palpate adds Ceres as reference and CHOLMOD as method.";

constexpr const char* EXTREME_FOOTER =
    "Example:\n"
    "  palpate bench extreme --groups contrast,one-node             where double ends, and what is said "
    "there\n"
    "\n"
    "Writes results.csv, results.json and results.md. Exit code 1 when a method gives a wrong number "
    "silently:\n"
    "an error above the one it states, without a guard or a status.";

template <typename Items>
std::string joined(const Items& items) {
    std::ostringstream text;
    for (const auto& item : items) text << (text.tellp() > 0 ? "," : "") << item;
    return text.str();
}

std::string command_of(const std::string& what, const BenchOptions& options) {
    std::string command = "palpate bench " + what;
    const auto add = [&](const char* name, const std::string& value) {
        if (!value.empty()) command += std::string(" --") + name + " " + value;
    };
    add("fields", joined(options.fields));
    add("groups", joined(options.groups));
    add("methods", joined(options.methods));
    add("nodes", joined(options.nodes));
    if (options.budget_s > 0.0) add("budget", study::number_text(options.budget_s));
    return command + (options.full ? " --full" : "");
}

Json about(const std::string& what, const BenchOptions& options, const study::Oracle& oracle) {
    return {{"schema", "palpate.bench_" + what + "/1"},
            {"palpate", PALPATE_VERSION},
            {"build", PALPATE_BUILD},
            {"command", command_of(what, options)},
            {"started_utc", record::utc_text(std::time(nullptr))},
            {"machine", study::machine_json()},
            {"palpate_reference", oracle ? "used" : "not installed: no Ceres, no CHOLMOD"}};
}

/// palpate-reference as a child, one for each question. Its libraries keep to one thread.
class ReferenceProgram {
public:
    explicit ReferenceProgram(fs::path program) : program_(std::move(program)) {}

    [[nodiscard]] Json ask(const std::string& command, const Json& request) const {
        const fs::path question = folder_ / "request.json", answer = folder_ / "answer.json",
                       words = folder_ / "words.txt";
        for (const fs::path& old : {answer, words}) fs::remove(old);
        record::write_file(question, request.dump());
        Child child("/bin/sh",
                    {"-c", "OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 exec \"$0\" \"$1\" < \"$2\" 2> \"$3\"",
                     program_.string(), command, question.string(), words.string()},
                    answer);
        while (!child.wait(100)) stop_when_interrupted();
        Json parsed = Json::parse(record::text_in(answer), nullptr, false);
        if (child.ended() == "exit 0" && parsed.is_object()) return parsed;
        throw study::OracleError("palpate-reference " + command + ": " + *child.ended() + ", " +
                                 record::text_in(words));
    }

private:
    fs::path program_;
    Scratch folder_;
};

/// Empty when it is not installed.
study::Oracle oracle_beside() {
    const fs::path program = program_beside("palpate-reference");
    if (access(program.c_str(), X_OK) != 0) return {};
    const auto reference = std::make_shared<ReferenceProgram>(program);
    return [reference](const std::string& command, const Json& request) {
        return reference->ask(command, request);
    };
}

/// A study at work: what it tells, and where its results go.
class Bench {
public:
    Bench(std::string what, const BenchOptions& options)
        : what_(std::move(what)),
          options_(options),
          directory_(options.out.empty() ? fs::path("out") / ("bench-" + what_) : fs::path(options.out)),
          out_(directory_),
          progress_(options.quiet),
          oracle_(oracle_beside()),
          about_(about(what_, options, oracle_)) {
        if (!oracle_) progress_.done("palpate-reference is not installed: no Ceres, no CHOLMOD");
    }

    [[nodiscard]] const study::Oracle& oracle() const { return oracle_; }
    [[nodiscard]] const Json& about_it() const { return about_; }
    [[nodiscard]] study::Watch watch() {
        return [this](const std::string& words) {
            stop_when_interrupted();
            if (!words.empty()) progress_.show(words);
        };
    }
    void write(const char* name, const std::string& text) { record::write_file(out_.path() / name, text); }
    [[nodiscard]] fs::path path(const char* name) const { return out_.path() / name; }
    void tell(const std::string& words) { progress_.done(words); }

    /// Words on stdout, or the document there and the words on stderr.
    void finish(const Json& document, const std::string& words) {
        out_.commit();
        progress_.leave();
        if (!options_.quiet) (options_.json ? std::cerr : std::cout) << words;
        if (options_.json) std::cout << document.dump(2) << '\n';
        if (!options_.quiet) std::cerr << "results: " << directory_.string() << '\n';
        if (!std::cout.flush()) throw std::runtime_error("stdout cannot be written");
    }

private:
    std::string what_;
    const BenchOptions& options_;
    fs::path directory_;
    record::OutputDirectory out_;
    Progress progress_;
    study::Oracle oracle_;
    Json about_;
};

study::PlateStudy study_of(const BenchOptions& options) {
    study::PlateStudy study;
    study.fields = options.fields;
    study.methods = options.methods;
    if (!options.nodes.empty()) study.nodes = options.nodes;
    if (options.full) study.nodes.insert(study.nodes.end(), study.cost_nodes.begin(), study.cost_nodes.end());
    if (!options.nodes.empty()) study.cost_nodes.clear();
    if (options.full) study.budget_s = 1.0;
    if (options.budget_s > 0.0) {
        study.budget_s = options.budget_s;
        study.sweeps_s = std::min(study.sweeps_s, options.budget_s);
    }
    return study;
}

int bench_plate(const BenchOptions& options) {
    catch_interrupts();
    Bench bench("plate", options);
    const std::vector<study::PlateRow> rows = run(study_of(options), bench.oracle(), bench.watch());
    const Json document = study::results_json(bench.about_it(), rows);
    const std::string words = study::results_markdown(rows);
    bench.write("results.csv", study::results_csv(rows));
    bench.write("results.json", document.dump(2) + "\n");
    bench.write("results.md", words);
    const std::string script = study::pareto_script(rows, bench.path("pareto.png"));
    const std::string missing = script.empty() ? "pareto.png needs the field hyperbolic or random, bare"
                                               : report::run_gnuplot(script, "pareto.png");
    if (!missing.empty()) bench.tell(missing);
    bench.finish(document, words);
    return 0;
}

int bench_extreme(const BenchOptions& options) {
    catch_interrupts();
    Bench bench("extreme", options);
    study::ExtremeStudy study{.groups = options.groups, .methods = options.methods};
    if (!options.nodes.empty()) study.nodes = options.nodes.front();
    const std::vector<study::ExtremeRow> rows = run(study, bench.oracle(), bench.watch());
    const Json document = study::extreme_json(bench.about_it(), rows);
    const std::size_t silent = study::count_silent(rows);
    const std::string words = study::extreme_markdown(rows) + "\n" +
                              (silent == 0 ? "No method was wrong in silence.\n"
                                           : std::to_string(silent) + " wrong numbers in silence.\n");
    bench.write("results.csv", study::extreme_csv(rows));
    bench.write("results.json", document.dump(2) + "\n");
    bench.write("results.md", words);
    bench.finish(document, words);
    return silent == 0 ? 0 : 1;
}

void add_common(CLI::App& command, BenchOptions& options, const std::string& what,
                const std::vector<std::string>& methods) {
    command.add_option("--methods", options.methods, "only these, with commas between: " + joined(methods))
        ->delimiter(',')
        ->check(CLI::IsMember(methods))
        ->option_text("NAMES");
    command.add_option("--out", options.out,
                       "result folder; an earlier one moves to DIR.1 (out/bench-" + what + ")");
    command.add_flag("--json", options.json, "print results.json on stdout, the words on stderr");
    command.add_flag("--quiet", options.quiet, "no progress, no words");
}

/// A grid that can be halved twice, its centre always a node.
std::string bad_nodes(const std::string& text) {
    study::PlateStudy study;
    try {
        study.nodes = {std::stol(text)};
    } catch (const std::exception&) {
        return text + " is not a number of nodes";
    }
    return problem_with(study).value_or("");
}

void add_plate(CLI::App& bench, const std::shared_ptr<BenchOptions>& options, std::function<int()>& chosen) {
    CLI::App* command = bench.add_subcommand("plate", "error against run time: methods x grids x plates");
    const std::vector<std::string> fields = study::field_names();
    command->add_option("--fields", options->fields, "only these, with commas between: " + joined(fields))
        ->delimiter(',')
        ->check(CLI::IsMember(fields))
        ->option_text("NAMES");
    add_common(*command, *options, "plate", study::method_names());
    command
        ->add_option("--nodes", options->nodes,
                     "nodes along a side, with commas between (17,33,65; hyperbolic bare 129 and 257 too)")
        ->delimiter(',')
        ->check(bad_nodes)
        ->option_text("N");
    command->add_option("--budget", options->budget_s, "seconds for each row (0.1; with --full 1)")
        ->check(CLI::Range(1e-3, 3600.0))
        ->option_text("S");
    command->add_flag("--full", options->full, "129 and 257 nodes for every plate, and longer times: hours");
    command->footer(PLATE_FOOTER);
    command->callback([options, &chosen] { chosen = [options] { return bench_plate(*options); }; });
}

void add_extreme(CLI::App& bench, const std::shared_ptr<BenchOptions>& options,
                 std::function<int()>& chosen) {
    CLI::App* command =
        bench.add_subcommand("extreme", "which methods hold, which guard speaks, at the extremes");
    const std::vector<std::string> groups = study::extreme_groups();
    command->add_option("--groups", options->groups, "only these, with commas between: " + joined(groups))
        ->delimiter(',')
        ->check(CLI::IsMember(groups))
        ->option_text("NAMES");
    add_common(*command, *options, "extreme", study::extreme_methods());
    command->add_option("--nodes", options->nodes, "nodes along the shorter side (33)")
        ->expected(1)
        ->check(CLI::IsMember({17, 33, 65}))
        ->option_text("N");
    command->footer(EXTREME_FOOTER);
    command->callback([options, &chosen] { chosen = [options] { return bench_extreme(*options); }; });
}

}  // namespace

void add_bench(CLI::App& palpate, std::function<int()>& chosen) {
    const auto options = std::make_shared<BenchOptions>();
    CLI::App* bench =
        palpate.add_subcommand("bench", "how fast and how right this program is, measured here");
    bench->require_subcommand(1);
    add_plate(*bench, options, chosen);
    add_extreme(*bench, options, chosen);
}

}  // namespace palpate::app

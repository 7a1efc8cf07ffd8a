/// The commands of `palpate`, each: how its command line reads, and what it does. Exit codes: 0 done, 1 a
/// verdict failed, 2 bad input, 3 device or link failed, 130 interrupted.
#pragma once
#include <CLI/CLI.hpp>
#include <functional>
#include <string>

namespace palpate::app {

/// A check for options: CLI11's own ranges let NaN through.
[[nodiscard]] std::string refusal_of_not_finite(const std::string& number);

/// Adds the command; `chosen` is set to what it does when the command line names it.
void add_run(CLI::App& palpate, std::function<int()>& chosen);
void add_bench(CLI::App& palpate, std::function<int()>& chosen);
void add_solve(CLI::App& palpate, std::function<int()>& chosen);
void add_device(CLI::App& palpate, std::function<int()>& chosen);
/// `palpate device latency`: of `device`, what else it has is palpate-falcon's.
void add_latency(CLI::App& device, std::function<int()>& chosen);
void add_doctor(CLI::App& palpate, std::function<int()>& chosen);
void add_trace(CLI::App& palpate, std::function<int()>& chosen);
#ifdef PALPATE_HAS_VIEW
void add_view(CLI::App& palpate, std::function<int()>& chosen);
#endif

}  // namespace palpate::app

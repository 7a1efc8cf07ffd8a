#include "host/app/solve_document.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "host/app/build_info.hpp"

namespace palpate::app {
namespace {

using report::Json;

/// The number, or null and why.
void put(Json& document, const std::string& name, std::optional<double> value, const std::string& why) {
    const bool there = value && std::isfinite(*value);
    document[name] = there ? Json(*value) : Json(nullptr);
    if (!there) document[name + "_why"] = why;
}

void put_file(Json& document, const std::string& name, const SolveFile& file) {
    if (file.path.empty()) {
        document[name] = nullptr;
        document[name + "_why"] = "output." + name + " is not given";
    } else if (!file.missing_why.empty()) {
        document[name] = nullptr;
        document[name + "_why"] = file.missing_why;
    } else {
        document[name] = file.path.string();
    }
}

void put_numbers(Json& document, const plate::Compliance& answer, std::size_t n_points) {
    const bool solved = answer.status == plate::Status::solved;
    const std::string unsolved =
        std::string(plate::name_of(answer.status)) + " " + plate::name_of(answer.method);
    put(document, "compliance_m_per_n", solved ? std::optional(answer.m_per_n) : std::nullopt,
        solved ? "the method gives no number" : unsolved);
    const bool told = solved && answer.deflection_m.size() == n_points;
    document["deflection_m"] = told ? Json(answer.deflection_m) : Json(nullptr);
    if (!told) document["deflection_m_why"] = solved ? "the method gives no deflections" : unsolved;
    const auto& bracket = answer.bracket_m_per_n;
    const std::string& why = answer.no_bracket_why;
    for (const std::size_t side : {0U, 1U}) {
        put(document, side == 0 ? "lower_m_per_n" : "upper_m_per_n",
            bracket ? std::optional((*bracket)[side]) : std::nullopt,
            why.empty() ? "there is no certificate for this plate" : why);
    }
    put(document, "estimated_relative_error", solved ? std::optional(answer.relative_error) : std::nullopt,
        solved ? "one grid alone does not tell its error" : unsolved);
}

void put_solver(Json& document, const SolveAnswer& answer) {
    const plate::Compliance& c = answer.compliance;
    document["method"] = plate::name_of(c.method);
    document["why"] = c.why;
    document["kernel"] = c.kernel;
    document["nodes"] = c.nodes.nx > 0 ? Json{c.nodes.nx, c.nodes.nz} : Json(nullptr);
    if (c.nodes.nx == 0) document["nodes_why"] = "no grid was needed";
    document["iterations"] = c.iterations;
    put(document, "residual", c.residual, "it is beyond all numbers");
    document["wall_s"] = answer.wall_s;
    document["warning"] = answer.warning.empty() ? Json(nullptr) : Json(answer.warning);
    document["status"] = plate::name_of(c.status);
}

std::string number(const Json& value, double times, const char* form) {
    std::array<char, 48> text{};
    std::snprintf(text.data(), text.size(), form, times * value.get<double>());
    return text.data();
}

std::string place_text(const Json& at_m) {
    return "(" + number(at_m[0], 1.0, "%.6g") + ", " + number(at_m[1], 1.0, "%.6g") + ") m";
}

/// "name        words\n"
std::string line(const std::string& name, const std::string& words) {
    std::string out = name;
    out.resize(std::max<std::size_t>(out.size(), 14), ' ');
    return out + words + "\n";
}

std::string compliance_lines(const Json& document) {
    const Json& c = document["compliance_m_per_n"];
    const Json& load = document["load"];
    const bool disc = load["radius_m"].get<double>() > 0.0;
    std::string out = line(
        "load",
        number(load["force_n"], 1.0, "%.6g") + " N at " + place_text(load["at_m"]) +
            (disc ? " on a disc of radius " + number(load["radius_m"], 1.0, "%.6g") + " m" : ", a point"));
    out += line("compliance", c.is_null()
                                  ? "none (" + document["compliance_m_per_n_why"].get<std::string>() + ")"
                                  : number(c, 1.0, "%.6g") + " m/N, a stiffness of " +
                                        number(1.0 / c.get<double>(), 1.0, "%.6g") + " N/m");
    const Json& error = document["estimated_relative_error"];
    out +=
        line("error", error.is_null()
                          ? "not known (" + document["estimated_relative_error_why"].get<std::string>() + ")"
                          : "about " + number(error, 100.0, "%.2g") + " %, estimated");
    if (document["lower_m_per_n"].is_number()) {
        out += line("certified", "between " + number(document["lower_m_per_n"], 1.0, "%.6g") + " and " +
                                     number(document["upper_m_per_n"], 1.0, "%.6g") + " m/N");
    } else {
        out += line("certified", "no: " + document["lower_m_per_n_why"].get<std::string>());
    }
    return out;
}

}  // namespace

Json solve_document(const scene::PlateFile& file, const SolveAnswer& answer, const SolveTold& told) {
    Json document = {
        {"schema", "palpate.solve/1"},
        {"palpate", PALPATE_VERSION},
        {"build", PALPATE_BUILD},
        {"command", told.command},
        {"started_utc", told.started_utc},
        {"file", file.path.string()},
        {"load",
         {{"at_m", file.load.at_m}, {"force_n", file.load.force_n}, {"radius_m", file.load.radius_m}}},
        {"points_m", file.output.points_m}};
    put_numbers(document, answer.compliance, file.output.points_m.size());
    put_solver(document, answer);
    put_file(document, "field", told.field);
    put_file(document, "plot", told.plot);
    return document;
}

std::string solve_page(const Json& document) {
    std::string out = compliance_lines(document);
    const Json& points_m = document["points_m"];
    for (std::size_t i = 0; i < points_m.size() && document["deflection_m"].is_array(); ++i) {
        out += line(i == 0 ? "deflection" : "",
                    number(document["deflection_m"][i], 1.0, "%.6g") + " m at " + place_text(points_m[i]));
    }
    const std::string why = document["why"];
    const Json& nodes = document["nodes"];
    const auto whole = [](const Json& n) { return std::to_string(n.get<long>()); };
    out += line("method", document["method"].get<std::string>() + (why.empty() ? "" : ": " + why));
    out += line("grid", nodes.is_null() ? document["nodes_why"].get<std::string>()
                                        : whole(nodes[0]) + " x " + whole(nodes[1]) + " nodes, " +
                                              number(document["wall_s"], 1e3, "%.3g") + " ms");
    if (document["warning"].is_string()) out += line("warning", document["warning"].get<std::string>());
    for (const char* name : {"field", "plot"}) {
        if (document[name].is_string()) out += line(name, document[name].get<std::string>());
    }
    return out;
}

}  // namespace palpate::app

#include "host/record/csv.hpp"

#include <charconv>
#include <cmath>

namespace palpate::record {

void append_number(std::string& out, double value) {
    if (std::isnan(value)) {
        out += "nan";
        return;
    }
    constexpr double WHOLE_MAX = 9007199254740992.0;  // 2^53
    char text[64];
    std::to_chars_result end{};
    if (std::fabs(value) < WHOLE_MAX && value == std::trunc(value)) {
        end = std::to_chars(text, text + sizeof text, static_cast<std::int64_t>(value));
    } else if (const float narrow = static_cast<float>(value); static_cast<double>(narrow) == value) {
        end = std::to_chars(text, text + sizeof text, narrow);  // reads back to the same float32
    } else {
        end = std::to_chars(text, text + sizeof text, value);
    }
    out.append(text, end.ptr);
}

void write_ticks_csv(const std::filesystem::path& file, std::span<const pal_tick> ticks) {
    constexpr std::size_t ROW_BYTES = 320;  // usual
    const std::vector<double> times_s = scene_times_s(ticks);
    std::string out;
    out.reserve((ticks.size() + 2) * ROW_BYTES);
    for (const Column& column : columns()) {
        if (!out.empty()) out += ',';
        out += column.name;
    }
    out += '\n';
    for (std::size_t i = 0; i < ticks.size(); ++i) {
        for (const Column& column : columns()) {
            append_number(out, column.value(ticks[i], times_s[i]));
            out += ',';
        }
        out.back() = '\n';
    }
    write_file(file, out);
}

void write_ticks_json(const std::filesystem::path& file) {
    nlohmann::ordered_json document;
    document["schema"] = "palpate.ticks/1";
    for (const Column& column : columns()) {
        document["columns"].push_back(
            {{"name", column.name}, {"unit", column.unit}, {"description", column.description}});
    }
    write_file(file, document.dump(1) + "\n");
}

}  // namespace palpate::record

#include "tests/host/cloud/samples.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iostream>
#include <iterator>

namespace palpate::cloud::test {
namespace {

/// Appends values to a PLY body, as words or packed.
class Writer {
public:
    Writer(Encoding encoding, std::string line_end) : encoding_(encoding), line_end_(std::move(line_end)) {}

    void put(const std::string& type, int value) {
        if (encoding_ == Encoding::ascii) {
            body_ += std::to_string(value) + ' ';
            return;
        }
        if (type == "char" || type == "int8") pack(static_cast<std::int8_t>(value));
        if (type == "uchar" || type == "uint8") pack(static_cast<std::uint8_t>(value));
        if (type == "short" || type == "int16") pack(static_cast<std::int16_t>(value));
        if (type == "ushort" || type == "uint16") pack(static_cast<std::uint16_t>(value));
        if (type == "int" || type == "int32") pack(static_cast<std::int32_t>(value));
        if (type == "uint" || type == "uint32") pack(static_cast<std::uint32_t>(value));
        if (type == "float" || type == "float32") pack(static_cast<float>(value));
        if (type == "double" || type == "float64") pack(static_cast<double>(value));
    }
    void end_entry() {
        if (encoding_ == Encoding::ascii) body_ += line_end_;
    }
    [[nodiscard]] const std::string& body() const { return body_; }

private:
    template <class Value>
    void pack(Value value) {
        std::array<char, sizeof(Value)> packed{};
        std::memcpy(packed.data(), &value, packed.size());
        if ((encoding_ == Encoding::big_endian) != (std::endian::native == std::endian::big))
            std::reverse(packed.begin(), packed.end());
        body_.append(packed.data(), packed.size());
    }

    Encoding encoding_;
    std::string line_end_;
    std::string body_;
};

constexpr std::array<std::array<int, 3>, 4> CORNERS{{{0, 10, 2}, {13, 0, 3}, {1, 13, 5}, {10, 11, 12}}};

}  // namespace

double Random::uniform() {
    state_ += 0x9E3779B97F4A7C15U;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
    return static_cast<double>((z ^ (z >> 31U)) >> 11U) * 0x1.0p-53;
}

Eigen::Vector3d Random::on_unit_sphere() {
    while (true) {
        const double x = 2.0 * uniform() - 1.0;
        const double y = 2.0 * uniform() - 1.0;
        const double z = 2.0 * uniform() - 1.0;
        const Eigen::Vector3d p(x, y, z);
        if (p.squaredNorm() <= 1.0 && p.squaredNorm() > 0.01) return p.normalized();
    }
}

std::string error_of(const std::function<void()>& call) {
    try {
        call();
    } catch (const Error& error) {
        return error.what();
    }
    return {};
}

std::optional<std::filesystem::path> shared_file(const std::string& name) {
    const std::filesystem::path file = std::filesystem::path(PALPATE_SHARED_DATA) / name;
    if (std::filesystem::exists(file)) return file;
    std::cout << "skipped: " << name << " is not in the shared test data\n";
    return std::nullopt;
}

std::string bytes_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void scale_to_15_cm(Cloud& cloud) {
    Eigen::Vector3d low = cloud.points_m.front();
    Eigen::Vector3d high = low;
    for (const Eigen::Vector3d& point : cloud.points_m) {
        low = low.cwiseMin(point);
        high = high.cwiseMax(point);
    }
    const double scale = 0.15 / (high - low).maxCoeff();
    const Eigen::Vector3d middle = 0.5 * (low + high);
    for (Eigen::Vector3d& point : cloud.points_m) point = (point - middle) * scale;
}

std::string sample_ply(Encoding encoding, const std::string& coordinate, const std::string& line_end) {
    const std::array<std::string, 3> names{"ascii", "binary_little_endian", "binary_big_endian"};
    std::string text;
    for (const std::string& line :
         {std::string("ply"), "format " + names[static_cast<std::size_t>(encoding)] + " 1.0",
          std::string("comment a sample"), std::string("obj_info num_cols 2"),
          std::string("element tristrips 2"), std::string("property list int short vertex_indices"),
          std::string("property float32 weight"), std::string("element vertex 4"),
          std::string("property uchar red"), "property " + coordinate + " x", "property " + coordinate + " y",
          std::string("property double quality"), "property " + coordinate + " z",
          std::string("element face 2"), std::string("property uint8 flags"),
          std::string("property list uchar uint vertex_index"), std::string("end_header")})
        text += line + line_end;
    Writer out(encoding, line_end);
    for (const int n : {3, 0}) {  // tristrips: the second is an empty list
        out.put("int", n);
        for (int i = 0; i < n; ++i) out.put("short", i - 1);
        out.put("float", 7);
        out.end_entry();
    }
    for (const std::array<int, 3>& corner : CORNERS) {
        out.put("uchar", 200);
        out.put(coordinate, corner[0]);
        out.put(coordinate, corner[1]);
        out.put("double", -4);
        out.put(coordinate, corner[2]);
        out.end_entry();
    }
    for (const std::array<int, 3>& face : {std::array<int, 3>{0, 1, 2}, std::array<int, 3>{3, 2, 1}}) {
        out.put("uchar", 1);
        out.put("uchar", 3);
        for (const int corner : face) out.put("uint", corner);
        out.end_entry();
    }
    return text + out.body();
}

std::vector<Eigen::Vector3d> sample_points() {
    std::vector<Eigen::Vector3d> points;
    for (const std::array<int, 3>& c : CORNERS) points.emplace_back(c[0], c[1], c[2]);
    return points;
}

}  // namespace palpate::cloud::test

/// Files and shapes that the tests of host/cloud share.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/cloud/cloud.hpp"

namespace palpate::cloud::test {

/// splitmix64: the same numbers with every compiler and library.
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    double uniform();  ///< in [0, 1)
    Eigen::Vector3d on_unit_sphere();

private:
    std::uint64_t state_;
};

/// The message of the Error that `call` throws; empty when it throws none.
[[nodiscard]] std::string error_of(const std::function<void()>& call);

/// A file of the shared test data; nullopt, and a line that says so, when it is not there.
[[nodiscard]] std::optional<std::filesystem::path> shared_file(const std::string& name);

/// The whole file.
[[nodiscard]] std::string bytes_of(const std::filesystem::path& file);

/// Centred on zero, the longest side of its box 0.15 m.
void scale_to_15_cm(Cloud& cloud);

enum class Encoding { ascii, little_endian, big_endian };

/// Two triangles over four points with a colour, an unknown element in between, and extra properties.
/// `coordinate` is a PLY type of any kind; the points are whole numbers.
[[nodiscard]] std::string sample_ply(Encoding encoding, const std::string& coordinate = "float",
                                     const std::string& line_end = "\n");

/// The points of sample_ply().
[[nodiscard]] std::vector<Eigen::Vector3d> sample_points();

}  // namespace palpate::cloud::test

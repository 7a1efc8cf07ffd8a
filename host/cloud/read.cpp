#include <array>
#include <fstream>
#include <system_error>

#include "host/cloud/formats.hpp"
#include "host/cloud/text.hpp"

namespace palpate::cloud {
namespace {

namespace fs = std::filesystem;

struct Format {
    std::string_view extension;  ///< in small letters, with the dot
    Cloud (*read)(std::string_view bytes, const std::string& name);
};
constexpr std::array FORMATS{Format{".obj", read_obj}, Format{".ply", read_ply}};

std::string small_letters(std::string text) {
    for (char& c : text) {
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    }
    return text;
}

std::string contents(const fs::path& file, const Place& place) {
    std::error_code error;
    const fs::file_status status = fs::status(file, error);
    if (!fs::exists(status)) place.fail("no such file; give the path of an OBJ or PLY file");
    if (!fs::is_regular_file(status)) place.fail("not a regular file; give the path of an OBJ or PLY file");
    const std::uintmax_t n_bytes = fs::file_size(file, error);
    std::ifstream in(file, std::ios::binary);
    if (error || !in) place.fail("cannot be opened; it must be readable");
    std::string bytes(n_bytes, '\0');
    in.read(bytes.data(), static_cast<std::streamsize>(n_bytes));
    if (static_cast<std::uintmax_t>(in.gcount()) != n_bytes)
        place.fail("cannot be read to its end; is it being written?");
    return bytes;
}

}  // namespace

Cloud read(const fs::path& file) {
    const std::string name = file.string();
    const Place place{&name};
    const std::string extension = small_letters(file.extension().string());
    for (const Format& format : FORMATS) {
        if (extension == format.extension) return format.read(contents(file, place), name);
    }
    place.fail("extension " + in_quotes(extension) + " is not one that is read; points come as .obj or .ply");
}

}  // namespace palpate::cloud

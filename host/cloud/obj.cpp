#include <array>
#include <limits>

#include "host/cloud/builder.hpp"
#include "host/cloud/formats.hpp"

namespace palpate::cloud {
namespace {

class ObjReader {
public:
    ObjReader(std::string_view bytes, const std::string& name) : lines_(bytes), name_(name) {}

    Cloud run() {
        std::string_view line;
        while (lines_.next(line)) {
            Words words(line);
            const std::string_view keyword = words.next();
            if (keyword == "v") vertex(words);
            if (keyword == "f") face(words);
        }
        if (builder_.n_points() == 0) here().fail("no vertex (`v x y z`) in the whole file; is it an OBJ?");
        if (highest_ > builder_.n_points()) out_of_range(Place{&name_, highest_line_}, highest_);
        return builder_.finish(here());
    }

private:
    [[nodiscard]] Place here() const { return Place{&name_, lines_.number()}; }

    /// x y z, then nothing, a weight, a colour, or a colour and its opacity.
    void vertex(Words& words) {
        std::array<double, 7> values{};
        std::size_t n = 0;
        for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
            const std::optional<double> value = real(word);
            if (!value)
                here().fail(in_quotes(word) +
                            " is not a number; write numbers as -0.5 or 1e-3, decimals with a point");
            if (n == values.size()) here().fail("a vertex of more than 7 numbers; a vertex is x y z [r g b]");
            values[n++] = *value;
        }
        if (n < 3) here().fail("a vertex of " + std::to_string(n) + " numbers; a vertex is x y z [r g b]");
        if (n == 5) here().fail("a vertex of 5 numbers; a vertex is x y z [r g b]");
        builder_.add_point({values[0], values[1], values[2]}, here());
    }

    void face(Words& words) {
        corners_.clear();
        for (std::string_view word = words.next(); !word.empty(); word = words.next())
            corners_.push_back(corner(word));
        builder_.add_polygon(corners_, here());
    }

    /// A corner is v, v/vt, v//vn or v/vt/vn; only v counts.
    Index corner(std::string_view word) {
        const std::size_t slash = word.find('/');
        const std::optional<std::int64_t> v = whole(word.substr(0, slash));
        if (!v || !rest_is_fine(word, slash))
            here().fail(in_quotes(word) +
                        " is not a corner; write v, v/vt, v//vn or v/vt/vn with whole numbers");
        const std::int64_t n_so_far = static_cast<std::int64_t>(builder_.n_points());
        if (*v == 0) here().fail("vertex 0 in a face; vertices count from 1");
        if (*v < -n_so_far || *v > std::numeric_limits<Index>::max()) out_of_range(here(), *v);
        if (*v < 0) return static_cast<Index>(n_so_far + *v);
        if (static_cast<std::size_t>(*v) > highest_) {  // may still be to come
            highest_ = static_cast<std::size_t>(*v);
            highest_line_ = lines_.number();
        }
        return static_cast<Index>(*v - 1);
    }

    static bool rest_is_fine(std::string_view word, std::size_t slash) {
        if (slash == std::string_view::npos) return true;
        const std::string_view rest = word.substr(slash + 1);
        const std::size_t second = rest.find('/');
        const std::string_view texture = rest.substr(0, second);
        if (second == std::string_view::npos) return whole(texture).has_value();
        return (texture.empty() || whole(texture)) && whole(rest.substr(second + 1));
    }

    template <class Number>
    [[noreturn]] void out_of_range(const Place& place, Number v) const {
        place.fail("vertex " + std::to_string(v) + " in a face, but there are " +
                   std::to_string(builder_.n_points()) + " vertices; an index must name one of them");
    }

    Lines lines_;
    const std::string& name_;
    Builder builder_;
    std::vector<Index> corners_;
    std::size_t highest_ = 0;  ///< largest index in a face, and the first line that has it
    std::size_t highest_line_ = 0;
};

}  // namespace

Cloud read_obj(std::string_view bytes, const std::string& name) {
    if (bytes.empty()) Place{&name}.fail("the file is empty; an OBJ has a line `v x y z` per vertex");
    return ObjReader(bytes, name).run();
}

}  // namespace palpate::cloud

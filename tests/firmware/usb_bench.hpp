/// palpate-falcon and usb_push in a simulated Falcon: files that they need, and what the simulator says of
/// itself.
#pragma once
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/firmware/falcon_script.hpp"
#include "tests/sim/usb/process.hpp"

namespace usbbench {

using nlohmann::json;

/// A folder of this test, gone with it.
class Folder {
public:
    Folder() {
        std::string name = "/tmp/pal-usb-XXXXXX";
        REQUIRE(mkdtemp(name.data()) != nullptr);
        path_ = name;
    }
    ~Folder() { (void)usbtest::call({"rm", "-r", path_}); }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    [[nodiscard]] std::string operator/(const std::string& name) const { return path_ + "/" + name; }

    /// A synthetic boot container of `n_words` words.
    [[nodiscard]] std::string firmware(std::size_t n_words = 1) const {
        const script::Bytes bytes = script::container(n_words);
        std::ofstream out(*this / "firmware.bin", std::ios::binary);
        for (const std::uint8_t byte : bytes) out.put(static_cast<char>(byte));
        return *this / "firmware.bin";
    }
    /// A hand that goes to the arms' origins again and again, so that a device that lost them finds them.
    [[nodiscard]] std::string path() const {
        std::ofstream out(*this / "path");
        out << "palpate-path 1\n";
        for (long long i = 0; i < 20000; ++i)
            out << i * 150000 << " 0 0 " << (i % 2 == 0 ? 72000 : 95000) << '\n';
        return *this / "path";
    }

private:
    std::string path_;
};

inline std::string falcon() {
    return usbtest::client("palpate-falcon");
}

/// `palpate-falcon ARGUMENTS` under a simulator of its own.
inline usbtest::Outcome run_falcon(const std::vector<std::string>& options,
                                   std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), falcon());
    return usbtest::run(options, arguments);
}

/// Output and errors come in one stream: the JSON document in it.
inline json document_in(const std::string& words) {
    INFO(words);
    const std::size_t begin = words.find("{\"schema\"");
    REQUIRE(begin != std::string::npos);
    const std::size_t end = words.find("}\n", begin);
    REQUIRE(end != std::string::npos);
    const json document = json::parse(words.substr(begin, end + 1 - begin), nullptr, false);
    REQUIRE(document.is_object());
    return document;
}

/// The bus' first device.
inline json device_status() {
    const usbtest::Outcome outcome = usbtest::simulator({"status", "--bus", usbtest::bus_folder()});
    INFO(outcome.words);
    REQUIRE(outcome.code == 0);
    return json::parse(outcome.words)["devices"][0];
}

inline bool at_rest(const json& status) {
    return status["motor_counts"] == json::array({0, 0, 0});
}

/// Looks until `condition` holds for the device; false after a limit that no healthy run reaches.
template <typename Condition>
bool device_comes_to(Condition condition) {
    for (int look = 0; look < 4000; ++look) {
        if (condition(device_status())) return true;
        poll(nullptr, 0, 2);
    }
    return false;
}

inline void fault(const std::string& words) {
    CHECK(usbtest::simulator({"fault", words, "--bus", usbtest::bus_folder()}).code == 0);
}

/// How often `piece` stands in the text.
inline int times_in(const std::string& text, const std::string& piece) {
    int n = 0;
    for (std::size_t at = text.find(piece); at != std::string::npos; at = text.find(piece, at + 1)) ++n;
    return n;
}

}  // namespace usbbench

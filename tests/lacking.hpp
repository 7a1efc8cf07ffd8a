/// Tests of what a machine may lack.
#pragma once
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

namespace palpate::test {

/// Says what is skipped; fails where all was installed for the tests (`./dev test` sets PALPATE_NEED_ALL).
inline void lacking(const std::string& what) {
    if (std::getenv("PALPATE_NEED_ALL") != nullptr) FAIL("missing: " << what);
    WARN("skipped: " << what << " is missing");
}

inline std::optional<std::filesystem::path> installed_bunny() {
    const std::filesystem::path file = "/usr/share/glmark2/models/bunny.obj";
    if (std::filesystem::exists(file)) return file;
    lacking("the bunny (package glmark2-data)");
    return std::nullopt;
}

inline bool mbpoll_is_missing() {
    static const bool missing = std::system("command -v mbpoll >/dev/null 2>&1") != 0;
    if (missing) lacking("mbpoll (package mbpoll)");
    return missing;
}

}  // namespace palpate::test

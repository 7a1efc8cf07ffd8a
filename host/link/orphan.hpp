/// What a killed process leaves is named after it, so that a later one of the same user can tell and remove
/// it.
#pragma once
#include <string>
#include <string_view>

namespace palpate::link {

/// "palpate-UID-": how every shared segment and scratch folder of this user begins; the process id follows.
[[nodiscard]] std::string owner_prefix();
/// Whether `name` is owner_prefix(), a process id and maybe "-" with more, and that process no longer lives.
[[nodiscard]] bool owner_is_gone(std::string_view name);

}  // namespace palpate::link

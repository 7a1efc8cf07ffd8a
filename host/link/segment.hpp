/// The shared segment between host and loop, as its creator sees it.
#pragma once
#include <functional>
#include <stdexcept>
#include <string>

#include "common/link.h"

namespace palpate::link {

struct Error : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A segment whose creator was killed: its name and what the loop and the host last wrote there.
using Salvage = std::function<void(const std::string& name, const pal_link& link)>;

/// Creates a POSIX shared-memory segment that only this user can open (0600), named after user and process,
/// prepared by pal_link_init; removed again when this goes.
class Segment {
public:
    /// Segments whose creator no longer lives are removed first, after `salvage` has seen each that is whole;
    /// without one they stay for somebody who keeps what is in them.
    explicit Segment(const Salvage& salvage = nullptr);
    ~Segment();
    Segment(const Segment&) = delete;
    Segment& operator=(const Segment&) = delete;
    [[nodiscard]] pal_link& link() const { return *link_; }
    [[nodiscard]] const std::string& name() const {
        return name_;
    }  ///< "/palpate-..." for palpate-loop --link

private:
    std::string name_;
    pal_link* link_ = nullptr;
};

}  // namespace palpate::link

// A shared segment that another process filled with anything: the check reads no byte beyond it, attaching
// refuses what is not one, and behind a header that passes the rings stay within their arrays whatever their
// words say. The first byte chooses which of the three; what the loop does with such a segment is
// session_fuzz.
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <memory>
#include <string>

#include "common/link.h"
#include "firmware/core/intake.h"
#include "firmware/port/linux/segment.h"
#include "host/link/orphan.hpp"
#include "tests/fuzz/good_table.hpp"

namespace {

using fuzz::require;

fuzz::Reached whole("header passed"), taken("table taken"), read("tick read"), attached("attached");

void check_bytes(fuzz::Bytes bytes) {
    // A block of just this size, so that the address sanitizer sees a byte too far.
    void* block = nullptr;
    require(posix_memalign(&block, alignof(pal_link), bytes.size()) == 0);
    std::copy(bytes.begin(), bytes.end(), static_cast<std::uint8_t*>(block));
    const pal_err err = pal_link_check(static_cast<const pal_link*>(block), bytes.size());
    require(err != PAL_OK || bytes.size() >= sizeof(pal_link));
    std::free(block);
}

void use_rings(pal_link& link) {
    pal_state_reader reader{};
    pal_tick tick{};
    for (int i = 0; i < 8; ++i) {
        if (pal_state_ring_read(&link.ticks, &reader, &tick)) read.note();
    }
    require(pal_state_ring_waiting(&link.ticks, &reader) <= PAL_STATE_RING_TICKS);
    pal_intake intake{};
    intake.ring = &link.tables;
    intake.limits = pal_table_limits_default();
    for (int i = 0; i < 6; ++i) {
        const pal_loop_tables* const tables = pal_intake_poll(&intake, i % 4 == 3);
        for (const pal_table* const table : {tables->now, tables->before}) {
            if (table == nullptr) continue;
            require(pal_table_header_ok(table));
            taken.note();
        }
        static_cast<void>(pal_intake_check(&intake));
        pal_table_ring_publish(&link.tables);
    }
    pal_state_ring_push(&link.ticks, &tick);
}

/// Every slot holds a good table, the last ones are the newer; one tick lies in the other ring.
void fill(pal_link& link) {
    pal_link_init(&link, 1);
    std::uint64_t id = 0;
    for (auto& slot : link.tables.slot) {
        fuzz::fill_good(slot.table, PAL_TABLE_NODES_MIN, ++id);
        pal_table_seal(&slot.table);
    }
    pal_table_ring_publish(&link.tables);
    const pal_tick tick{};
    pal_state_ring_push(&link.ticks, &tick);
}

/// Words of a good segment overwritten: place (3 bytes) and value (4).
void check_rings(fuzz::Bytes bytes) {
    static const auto link = std::make_unique<pal_link>();
    fill(*link);
    while (bytes.size() >= 7) {
        const auto low = fuzz::take<std::uint16_t>(bytes);
        std::size_t place = low | std::size_t{fuzz::take<std::uint8_t>(bytes)} << 16U;
        const std::array<std::size_t, 4> words{offsetof(pal_link, tables.state),
                                               offsetof(pal_link, ticks.begun),
                                               offsetof(pal_link, ticks.done), 0};
        if (place % 4 != 0) place = words[place % 4 - 1];  // the words that matter most
        const auto word = fuzz::take<std::uint32_t>(bytes);
        std::memcpy(reinterpret_cast<std::uint8_t*>(link.get()) + place % sizeof *link / 4 * 4, &word,
                    sizeof word);
    }
    if (pal_link_check(link.get(), sizeof *link) != PAL_OK) return;
    whole.note();
    use_rings(*link);
}

/// Shared memory named so that a later run of any program removes it if this one crashes.
class SharedObject {
public:
    SharedObject()
        : name_("/" + palpate::link::owner_prefix() + std::to_string(getpid()) + "-fuzz"),
          file_(shm_open(name_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600)) {
        require(file_ >= 0);
    }
    ~SharedObject() {
        close(file_);
        shm_unlink(name_.c_str());
    }
    SharedObject(const SharedObject&) = delete;
    SharedObject& operator=(const SharedObject&) = delete;
    void set(fuzz::Bytes bytes, std::size_t n_bytes) {
        require(ftruncate(file_, 0) == 0 && ftruncate(file_, static_cast<off_t>(n_bytes)) == 0);
        const std::size_t n = std::min(bytes.size(), n_bytes);
        require(pwrite(file_, bytes.data(), n, 0) == static_cast<ssize_t>(n));
    }
    [[nodiscard]] const char* name() const { return name_.c_str(); }

private:
    std::string name_;
    int file_;
};

void check_attach(fuzz::Bytes bytes) {
    static SharedObject object;
    const auto which = fuzz::take<std::uint8_t>(bytes);
    const std::array sizes{bytes.size(), sizeof(pal_link), sizeof(pal_link) - 1, sizeof(pal_link) + 4096};
    const std::size_t n_bytes = sizes[which % sizes.size()];
    object.set(bytes, n_bytes);
    pal_link* link = nullptr;
    if (pal_segment_attach(object.name(), &link) != PAL_OK) return;
    require(n_bytes >= sizeof(pal_link));
    attached.note();
    use_rings(*link);
    pal_segment_detach(link);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Bytes bytes(data, size);
    const auto kind = fuzz::take<std::uint8_t>(bytes);
    if (kind % 3 == 0) check_bytes(bytes);
    if (kind % 3 == 1) check_rings(bytes);
    if (kind % 3 == 2) check_attach(bytes);
    return 0;
}

// Every execution of the hand-over of tables: writer, tick and checker, each of the two processes killed at
// any step and started again.
#include <catch2/catch.hpp>

#include "tests/common/explore_table.hpp"

// In place of the real one, which reads 54 kilobytes: the checker's look at a table.
bool pal_table_check_slice(pal_table_checking* /*checking*/, const pal_table* table,
                           const pal_table_limits* /*limits*/, std::uint32_t /*n_words_max*/, pal_err* err) {
    *err = static_cast<hand_over::Hand*>(explore::Machine::running)->check(table);
    return true;
}

namespace {

using hand_over::Mutant;
using hand_over::Setting;

explore::Result run(const Setting& setting) {
    hand_over::Hand hand(setting);
    return explore::explore(hand);
}

/// Ids: 1, 2 and 3 from an empty ring; 3, 4 and 5 behind two that have been through.
std::uint32_t second_id(bool warm) {
    return warm ? 4 : 2;
}

}  // namespace

TEST_CASE("in no execution is a table torn, unchecked, older or written while in use, nor anybody stuck") {
    Setting setting;
    if (explore::soak()) {
        setting.n_publications = 4;
        setting.n_polls = 6;
        setting.n_checks = 3;
    } else if (explore::SANITIZED) {
        setting.n_publications = 2;
        setting.writer_deaths = 0;
    }
    std::size_t n_states = 0, n_steps = 0;
    for (const bool warm : {false, true}) {
        for (const std::uint32_t fade_polls : {0U, 1U}) {
            for (const std::uint32_t bad_ids : {0U, 1U << second_id(warm)}) {
                setting.warm = warm;
                setting.fade_polls = fade_polls;
                setting.bad_ids = bad_ids;
                const explore::Result result = run(setting);
                INFO("warm " << warm << ", fade " << fade_polls << ", bad " << bad_ids << ':'
                             << result.trace);
                CHECK(result.failure.empty());
                CHECK(result.n_ends > 0);
                n_states += result.n_states;
                n_steps += result.n_steps;
            }
        }
    }
    WARN(n_states << " states, " << n_steps << " steps");
}

TEST_CASE("each process may die twice") {
    if (!explore::soak()) return;
    Setting setting;
    setting.writer_deaths = setting.reader_deaths = 2;
    setting.bad_ids = 1U << second_id(true);
    const explore::Result result = run(setting);
    INFO(result.trace);
    CHECK(result.failure.empty());
    WARN(result.n_states << " states, " << result.n_steps << " steps");
}

TEST_CASE("the explorer finds what each mutant of the hand-over does") {
    struct Case {
        Mutant mutant;
        const char* failure;
    };
    const auto [mutant, failure] = GENERATE(values<Case>({
        {Mutant::relaxed_publish, "race: read with a write"},
        {Mutant::relaxed_take, "race: write with a read"},
        {Mutant::relaxed_order, "race: read with a write"},
        {Mutant::relaxed_verdict, "race: read with a write"},
        {Mutant::split_words, "no slot for the writer"},
        {Mutant::not_dirty, "the newest table never comes into use"},
        {Mutant::not_checked, "an unchecked table is used"},
        {Mutant::take_in_fade, "a fade loses the table before"},
    }));
    CHECK(run({.mutant = mutant}).failure == failure);
}

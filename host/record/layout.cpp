#include <bit>

#include "host/record/record.hpp"

namespace palpate::record {

static_assert(std::endian::native == std::endian::little, "the record file is little-endian");

#define PAL_ONE(type, member) \
    { #member, type, 1, offsetof(pal_tick, member), sizeof(pal_tick::member) }
#define PAL_SOME(type, member, count) \
    { #member, type, count, offsetof(pal_tick, member), sizeof(pal_tick::member) / (count) }

std::span<const Field> fields() {
    static constexpr Field table[] = {
        PAL_ONE("<u8", t_ns),
        PAL_ONE("<u4", tick),
        PAL_ONE("<u4", faults),
        PAL_ONE("<u4", state),
        PAL_ONE("<u4", stop),
        PAL_ONE("<u8", table_id),
        PAL_ONE("<u8", before_id),
        PAL_ONE("<u4", table_age_ticks),
        PAL_ONE("<f4", fade_weight),
        PAL_ONE("<f4", gain),
        PAL_ONE("<u4", n_missed),
        PAL_ONE("u1", buttons),
        PAL_ONE("u1", homed),
        PAL_ONE("u1", truth_valid),
        PAL_ONE("u1", reserved_byte),
        PAL_SOME("<i2", encoder_counts, 3),
        PAL_SOME("<i2", motor_counts, 3),
        PAL_SOME("<f4", position_m, 3),
        PAL_SOME("<f4", velocity_m_per_s, 3),
        PAL_SOME("<f4", force_n, 3),
        PAL_SOME("<f4", table_force_n, 3),
        PAL_ONE("<f4", depth_m),
        PAL_ONE("<f4", k_n_per_m),
        PAL_ONE("<f4", potential_j),
        PAL_ONE("<f4", fade_work_j),
        PAL_ONE("<f4", hand_work_j),
        PAL_SOME("<f4", reserved_j, 3),
        PAL_SOME("<u8", stamp_ns, 6),
        PAL_SOME("<f4", truth_position_m, 3),
        PAL_SOME("<f4", truth_force_n, 3),
        PAL_SOME("<f4", hand_target_m, 3),
        PAL_ONE("<u4", path_tick),
        PAL_ONE("<u4", wake_late_ns),
        PAL_SOME("<u4", reserved, 3),
    };
    return table;
}

#undef PAL_ONE
#undef PAL_SOME

std::string numpy_dtype() {
    std::string out;
    for (const Field& field : fields()) {
        out += out.empty() ? "[" : ", ";
        out += std::string("(\"") + field.name + "\", \"" + field.type + "\"";
        if (field.count > 1) out += ", (" + std::to_string(field.count) + ",)";
        out += ")";
    }
    return out + "]";
}

}  // namespace palpate::record

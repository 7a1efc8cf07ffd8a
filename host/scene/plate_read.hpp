/// From a TOML tree to a plate file, by the table of keys.
#pragma once
#include "host/scene/plate_keys.hpp"
#include "host/scene/read.hpp"

namespace palpate::scene {

/// Types, ranges of single values, words, unknown and missing keys; the middle as default of load.at_m.
/// What values mean together is not looked at. Throws Error.
void read_plate_tree(Source& source, const toml::table& tree, PlateFile& file);

}  // namespace palpate::scene

/// A hand's path as text: "palpate-path 1", then a line "t_us x_um y_um z_um" of whole numbers for each
/// point, in the device frame, times increasing.
#pragma once
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "sim/hand/hand.h"

typedef struct pal_path_file {
    pal_hand_point* points;  ///< free() it
    uint32_t n_points;
} pal_path_file;

/// False with "file:line: what, and what would be right" in `why`.
bool pal_path_file_read(const char* file, pal_path_file* out, char* why, size_t n_why);

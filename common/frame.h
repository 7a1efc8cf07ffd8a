/// Where the workspace frame lies in the device frame: same axes (x right, y up, z towards the user), origin
/// at the middle of the Falcon's reach. docs/FRAMES.md.
#pragma once

#define PAL_WORKSPACE_CENTRE_X_M 0.0
#define PAL_WORKSPACE_CENTRE_Y_M 0.0
#define PAL_WORKSPACE_CENTRE_Z_M 0.12

/// Box around the workspace's origin in which a scene may ask the hand to go: the Falcon's 102 mm cube, cut
/// at the inner stop (z 0.075 m of the device).
#define PAL_WORKSPACE_HALF_X_M 0.050
#define PAL_WORKSPACE_HALF_Y_M 0.050
#define PAL_WORKSPACE_MIN_Z_M (-0.045)
#define PAL_WORKSPACE_MAX_Z_M 0.050

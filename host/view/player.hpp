/// Where in a run the viewer is: play, pause, step, scrub. No clock of its own.
#pragma once

namespace palpate::view {

struct Player {
    double duration_s = 0.0;
    double t_s = 0.0;
    double speed = 1.0;  ///< run seconds per second
    bool is_playing = false;

    /// Moves on by `dt_s` of the viewer's time when playing; stops at the end.
    void advance(double dt_s);
    /// Play or pause; at the end, play starts over.
    void toggle();
    /// Pauses and moves by `by_s`, within the run.
    void step(double by_s);
    /// Moves to `to_s`, within the run.
    void seek(double to_s);
    /// Twice as fast, or half as fast, from 1/64 to 16.
    void faster();
    void slower();
};

}  // namespace palpate::view

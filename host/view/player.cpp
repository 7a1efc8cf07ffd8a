#include "host/view/player.hpp"

#include <algorithm>

namespace palpate::view {
namespace {
constexpr double kSlowest = 1.0 / 64.0;
constexpr double kFastest = 16.0;
}  // namespace

void Player::advance(double dt_s) {
    if (!is_playing) return;
    seek(t_s + speed * dt_s);
    if (t_s >= duration_s) is_playing = false;
}

void Player::toggle() {
    if (!is_playing && t_s >= duration_s) t_s = 0.0;
    is_playing = !is_playing;
}

void Player::step(double by_s) {
    is_playing = false;
    seek(t_s + by_s);
}

void Player::seek(double to_s) {
    t_s = std::clamp(to_s, 0.0, std::max(duration_s, 0.0));
}
void Player::faster() {
    speed = std::min(2.0 * speed, kFastest);
}
void Player::slower() {
    speed = std::max(0.5 * speed, kSlowest);
}

}  // namespace palpate::view

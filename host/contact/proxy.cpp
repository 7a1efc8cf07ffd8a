#include "host/contact/proxy.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace palpate::contact {
namespace {

// All in radii of the proxy.
constexpr double feel_radius = 1.25;
constexpr double stride = 0.25;      // of one step near points: a wall cannot be stepped through
constexpr double settled = 1e-4;     // of one step
constexpr double resting = 1.05;     // a proxy no higher than this may be held
constexpr double seen_radius = 2.0;  // beyond it follow() reports nothing
constexpr int moves_max = 128;

Eigen::Vector3d shortened(const Eigen::Vector3d& way, double longest) {
    const double length = way.norm();
    return length > longest ? Eigen::Vector3d(way * (longest / length)) : way;
}

/// Gain of the tangential steps. In a bowl that is narrower than twice the depth a full step goes past the
/// answer by more than it was away from it; half the gain at every turn makes it settle.
class Slide {
public:
    Eigen::Vector3d step(const Eigen::Vector3d& tangential) {
        gain_ = tangential.dot(before_) < 0.0 ? 0.5 * gain_ : std::min(1.0, 1.2 * gain_);
        before_ = tangential;
        return gain_ * tangential;
    }

private:
    double gain_ = 1.0;
    Eigen::Vector3d before_ = Eigen::Vector3d::Zero();
};

}  // namespace

Proxy::Proxy(const cloud::Cloud& cloud, const cloud::Tree& tree, const cloud::Graph& graph, double radius_m)
    : cloud_(&cloud), tree_(&tree), graph_(&graph), radius_m_(radius_m) {
    if (cloud.normals.size() != cloud.points_m.size() || cloud.points_m.empty()) {
        throw std::invalid_argument("Proxy: the cloud has no points or no normals; call orient() first");
    }
    if (!(radius_m > 0.0)) throw std::invalid_argument("Proxy: the radius must be positive");
}

void Proxy::reset() {
    last_.reset();
}

/// Overshoot of the points that face the place and lie in the feeling sphere; nullopt without any.
std::optional<Proxy::Touch> Proxy::feel(const Eigen::Vector3d& centre_m) const {
    const double reach_m = feel_radius * radius_m_;
    Touch touch{Eigen::Vector3d::Zero(), 0, reach_m};
    bool found = false;
    for (const cloud::Index i : tree_->within(centre_m, reach_m)) {
        const Eigen::Vector3d out = centre_m - cloud_->points_m[i];
        const double r = out.norm();
        if (!(cloud_->normals[i].dot(out) > 0.0) || !(r < reach_m)) continue;
        touch.normal += (reach_m - r) / r * out;
        if (r < touch.height_m) {
            touch.height_m = r;
            touch.nearest = i;
        }
        found = true;
    }
    if (!found) return std::nullopt;
    const double length = touch.normal.norm();
    // Points all round the place leave no direction: then the nearest one's own.
    if (length > 1e-9 * reach_m) {
        touch.normal /= length;
    } else {
        touch.normal = cloud_->normals[touch.nearest];
    }
    return touch;
}

Eigen::Vector3d Proxy::start(const Eigen::Vector3d& tool_m) const {
    const cloud::Index i = tree_->nearest(tool_m);
    const Eigen::Vector3d out = tool_m - cloud_->points_m[i];
    const bool inside = cloud_->normals[i].dot(out) < 0.0 && out.norm() < seen_radius * radius_m_;
    return inside ? Eigen::Vector3d(cloud_->points_m[i] + radius_m_ * cloud_->normals[i]) : tool_m;
}

/// As far towards the tool as there is certainly no point to be felt, a stride at least.
Eigen::Vector3d Proxy::free_move(const Eigen::Vector3d& way_m) const {
    const Eigen::Vector3d& at = last_->proxy_m;
    const double clear_m = (cloud_->points_m[tree_->nearest(at)] - at).norm() - feel_radius * radius_m_;
    return shortened(way_m, std::max(stride * radius_m_, clear_m));
}

/// Downhill along edges to the cloud point nearest to a place.
cloud::Index Proxy::walk(const Eigen::Vector3d& to_m, cloud::Index from) const {
    double best = (cloud_->points_m[from] - to_m).squaredNorm();
    for (bool moved = true; moved;) {
        moved = false;
        for (const cloud::Index next : graph_->neighbours(from)) {
            const double square = (cloud_->points_m[next] - to_m).squaredNorm();
            if (!(square < best)) continue;
            best = square;
            from = next;
            moved = true;
            break;
        }
    }
    return from;
}

Contact Proxy::contact_at(const Eigen::Vector3d& centre_m, const Eigen::Vector3d& tool_m,
                          const std::optional<Touch>& touch) const {
    if (!touch) {
        const cloud::Index nearest = tree_->nearest(centre_m);
        return {centre_m, cloud_->normals[nearest], nearest, false};
    }
    const Eigen::Vector3d way = tool_m - centre_m;
    const bool touching = way.norm() > settled * radius_m_ && touch->normal.dot(way) < 0.0 &&
                          touch->height_m < resting * radius_m_;
    cloud::Index nearest = touch->nearest;
    if (last_ && last_->touching) {
        // Along the sheet that is touched, unless something else that faces the proxy is clearly nearer: a
        // second wall.
        const cloud::Index walked = walk(centre_m, last_->nearest);
        const double walked_m = (cloud_->points_m[walked] - centre_m).norm();
        if (walked_m < touch->height_m + 0.5 * radius_m_) nearest = walked;
    }
    return {centre_m, touch->normal, nearest, touching};
}

std::optional<Contact> Proxy::follow(const Eigen::Vector3d& tool_m) {
    const Eigen::Vector3d begin = last_ ? last_->proxy_m : start(tool_m);
    std::optional<Touch> touch = feel(begin);
    last_ = contact_at(begin, tool_m, touch);
    Slide slide;
    for (int step = 0; step < moves_max; ++step) {
        const Eigen::Vector3d way = tool_m - last_->proxy_m;
        const double towards_m = touch ? -touch->normal.dot(way) : 0.0;
        Eigen::Vector3d move = Eigen::Vector3d::Zero();
        if (touch && (towards_m > 0.0 || touch->height_m < radius_m_)) {
            // v_n . v_h < 0: down to the surface at most, out of it where points are inside, and along it to
            // where the way to the tool is the normal.
            const Eigen::Vector3d along = way + towards_m * touch->normal;
            const double down_m = std::min(touch->height_m - radius_m_, std::max(towards_m, 0.0));
            move = shortened(slide.step(along), stride * radius_m_) - down_m * touch->normal;
        } else {
            move = free_move(way);
        }
        const Eigen::Vector3d next = last_->proxy_m + move;
        touch = feel(next);
        last_ = contact_at(next, tool_m, touch);
        if (move.norm() < settled * radius_m_) break;
    }
    const double gap_m = (cloud_->points_m[last_->nearest] - last_->proxy_m).norm();
    if (!last_->touching && gap_m > seen_radius * radius_m_) return std::nullopt;
    return last_;
}

}  // namespace palpate::contact

#include "host/scene/world.hpp"

#include <xxhash.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "common/frame.h"
#include "host/cloud/outer_side.hpp"
#include "host/cloud/text.hpp"
#include "host/scene/frames.hpp"

namespace palpate::scene {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double SUPPORT_IN_SPACINGS = 4.0;  // of the smooth skin's weights
constexpr double PATH_STEP_S = 0.01;
constexpr double REACH_SLACK_M = 1e-9;   // feet on the skin are good to 1e-10 m
constexpr double EXCESS_SHOWN_M = 1e-4;  // the last digit of an excess in an error
constexpr double SIDE_SLACK = 1e-6;      // of a length: scans are often in single precision

Vector3d vec(const Vec3& v) {
    return {v[0], v[1], v[2]};
}

std::string printed(const char* format, double number) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), format, number);
    return text.data();
}

std::string mm(double m) {
    return printed(std::abs(m) < EXCESS_SHOWN_M ? "%.1g mm" : "%.1f mm", 1e3 * m);
}

double metres_per_unit(const std::string& unit) {
    if (unit == "cm") return 1e-2;
    if (unit == "mm") return 1e-3;
    if (unit == "um") return 1e-6;
    if (unit == "inch") return 0.0254;
    return 1.0;
}

/// From the file's axes to the object's (docs/FRAMES.md).
void turn_axes(const Object& object, cloud::Cloud& cloud) {
    if (object.axes == "file") return;
    const Matrix3d turn = convention(object.axes).turn;
    for (Vector3d& p : cloud.points_m) p = turn * p;
    for (Vector3d& n : cloud.normals) n = turn * n;
}

void check_axes(const Scene& scene, const std::filesystem::path& file) {
    const SpaceComment said = space_comment(file);
    if (said.space.empty() || scene.object.axes == "file" || said.space == scene.object.axes) return;
    refuse(file.string() + ":" + std::to_string(said.line),
           "the file says SPACE=" + cloud::printable(said.space) + ", the scene object.axes = \"" +
               scene.object.axes + "\"; set object.axes to what the file says, or correct the file");
}

struct Box {
    Vector3d low, high;
    [[nodiscard]] double longest_side_m() const { return (high - low).maxCoeff(); }
};

Box box_of(const cloud::Cloud& cloud) {
    Box box{cloud.points_m.front(), cloud.points_m.front()};
    for (const Vector3d& p : cloud.points_m) {
        box.low = box.low.cwiseMin(p);
        box.high = box.high.cwiseMax(p);
    }
    return box;
}

/// Object metres: centred on its box where size_m scales it, as the file has it otherwise.
void scale(const Object& object, cloud::Cloud& cloud) {
    const Box box = box_of(cloud);
    const bool sized = object.size_m > 0.0;
    const double factor = sized ? object.size_m / box.longest_side_m() : metres_per_unit(object.length_unit);
    const Vector3d middle = sized ? Vector3d(0.5 * (box.low + box.high)) : Vector3d::Zero();
    for (Vector3d& p : cloud.points_m) p = (p - middle) * factor;
}

/// 0 below -edge/2, 1 above +edge/2 of `inside_m`, smooth between.
double smooth_step(double inside_m, double edge_m) {
    if (!(edge_m > 0.0)) return inside_m >= 0.0 ? 1.0 : 0.0;
    const double t = std::clamp(inside_m / edge_m + 0.5, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

/// Nearest place of the skin, in object metres before placement.
contact::Foot on_the_skin(const World& world, const Vector3d& at_m, const std::string& key) {
    const auto foot = world.surface->foot(at_m, world.tree->nearest(at_m));
    if (!foot) {
        refuse(where(world.scene, key),
               key + ": there is no smooth skin near this place; choose a point on the scan");
    }
    return *foot;
}

void apply(const Change& change, World& world, std::size_t number) {
    const std::string key = "change[" + std::to_string(number) + "].at_m";
    if (change.shape == Change::Shape::nodule) {
        const Vector3d at = on_the_skin(world, vec(change.at_m), key).point_m;
        for (std::size_t i = 0; i < world.cloud.points_m.size(); ++i) {
            const double distance = (world.cloud.points_m[i] - at).norm();
            const double share = smooth_step(change.radius_m - distance, change.edge_m);
            world.cloud.young_pa[i] *= 1.0 + (change.factor[0] - 1.0) * share;
        }
        world.nodules.push_back({at, change.radius_m});
        return;
    }
    const Vector3d from = vec(change.from_m), way = vec(change.to_m) - from;
    for (std::size_t i = 0; i < world.cloud.points_m.size(); ++i) {
        const double t = std::clamp((world.cloud.points_m[i] - from).dot(way) / way.squaredNorm(), 0.0, 1.0);
        world.cloud.young_pa[i] *= change.factor[0] + (change.factor[1] - change.factor[0]) * t;
    }
}

/// Rotation that takes `normal` to +z (towards the user) and keeps the object's y as far up as it can.
Matrix3d facing_operator(const Vector3d& normal) {
    const Vector3d up = std::abs(normal.y()) < 0.99 ? Vector3d::UnitY() : Vector3d::UnitZ();
    const Vector3d y = (up - up.dot(normal) * normal).normalized();
    Matrix3d turn;
    turn << y.cross(normal).transpose(), y.transpose(), normal.transpose();
    return turn;
}

Matrix3d turned(const Vec3& turn_deg) {
    const auto about = [&](std::size_t axis, const Vector3d& direction) {
        return Eigen::AngleAxisd(turn_deg[axis] * (3.14159265358979323846 / 180.0), direction)
            .toRotationMatrix();
    };
    return about(2, Vector3d::UnitZ()) * about(1, Vector3d::UnitY()) * about(0, Vector3d::UnitX());
}

Pose pose_of(const World& world) {
    const Placement& placement = world.scene.placement;
    Pose pose;
    if (placement.facing == "operator") {
        pose.turn = facing_operator(on_the_skin(world, vec(placement.focus_m), "placement.focus_m").normal);
    }
    if (placement.turn_deg != Vec3{}) pose.turn = turned(placement.turn_deg) * pose.turn;
    pose.shift_m = placement.position_scale * vec(placement.at_m) - pose.turn * vec(placement.focus_m);
    return pose;
}

void place(World& world) {
    world.pose = pose_of(world);
    for (Vector3d& p : world.cloud.points_m) p = world.pose(p);
    for (Vector3d& n : world.cloud.normals) n = world.pose.turn * n;
    for (Nodule& nodule : world.nodules) nodule.at_m = world.pose(nodule.at_m);
}

/// Trees and surfaces refer to the points' places: made anew whenever these change.
void index(World& world) {
    world.tree = std::make_unique<cloud::Tree>(world.cloud.points_m);
    if (world.cloud.normals.empty()) cloud::orient(world.cloud, *world.tree);
    world.graph = std::make_unique<cloud::Graph>(world.cloud, *world.tree);
    world.spacing_m = cloud::median_spacing_m(world.cloud, *world.tree);
    world.surface =
        std::make_unique<contact::Surface>(world.cloud, *world.graph, SUPPORT_IN_SPACINGS * world.spacing_m);
}

/// object.sides = "outer": only the side of a double wall that the hand comes to first.
void drop_other_side(World& world) {
    const Scene& scene = world.scene;
    if (scene.object.sides != "outer") return;
    const Vector3d from_m =
        vec(scene.hand.path.empty() ? scene.placement.focus_m : scene.hand.path.front().at_m);
    const auto kept = cloud::outer_side(world.cloud, *world.tree, from_m);
    world.n_other_side = world.cloud.points_m.size() - kept.size();
    if (world.n_other_side == 0) return;
    world.cloud = cloud::subset(world.cloud, kept);
    index(world);
}

/// A stretch of the hand's path, as errors name it: one point, or what is between it and the next.
struct Stretch {
    std::size_t point;
    bool to_next;
};

[[noreturn]] void refuse_path(const Scene& scene, const Stretch& at, double t_s, const std::string& what) {
    std::vector<std::string> keys;
    for (std::size_t i = at.point; i <= at.point + (at.to_next ? 1 : 0); ++i) {
        const std::string point = "hand.path[" + std::to_string(i) + "]";
        keys.insert(keys.end(), {point + ".at_m", point + ".depth_m"});
    }
    refuse(where_among(scene, keys), "hand.path[" + std::to_string(at.point) + "]" +
                                         (at.to_next ? " to [" + std::to_string(at.point + 1) + "]" : "") +
                                         " at t_s = " + printed("%g", t_s) + " " + what);
}

/// How far a place of the hand is outside the workspace, along the axis where that is most.
struct Excess {
    double over_m;  ///< not above 0: inside
    int axis;
    double limit_m;
};

Excess excess_of(const Vector3d& tool_m) {
    const Vector3d low(-PAL_WORKSPACE_HALF_X_M, -PAL_WORKSPACE_HALF_Y_M, PAL_WORKSPACE_MIN_Z_M);
    const Vector3d high(PAL_WORKSPACE_HALF_X_M, PAL_WORKSPACE_HALF_Y_M, PAL_WORKSPACE_MAX_Z_M);
    Excess worst{-std::numeric_limits<double>::infinity(), 0, 0.0};
    for (int axis = 0; axis < 3; ++axis) {
        const double above = tool_m[axis] - high[axis], below = low[axis] - tool_m[axis];
        const double over = std::max(above, below);
        if (over > worst.over_m) worst = {over, axis, above > below ? high[axis] : low[axis]};
    }
    return worst;
}

/// From target `first` at point `leg` to `last` at the next: refuses at the worst target, so that mending
/// what the error says mends the whole leg. A point, the first one before the second, goes before what
/// differs from it by less than the error shows.
void check_reach(const World& world, std::size_t leg, std::size_t first, std::size_t last) {
    const auto over_m = [&](std::size_t i) { return excess_of(world.path[i].tool_m).over_m; };
    std::size_t inside = first;  // the worst of those between
    for (std::size_t i = first + 1; i < last; ++i) {
        if (inside == first || over_m(i) > over_m(inside)) inside = i;
    }
    std::size_t worst = first;
    for (const std::size_t i : {last, inside}) {
        const double shown_m = over_m(worst) > REACH_SLACK_M ? EXCESS_SHOWN_M : 0.0;
        if (over_m(i) > over_m(worst) + shown_m) worst = i;
    }
    const Excess most = excess_of(world.path[worst].tool_m);
    if (!(most.over_m > REACH_SLACK_M)) return;
    const bool at_next = worst == last && last != first;
    refuse_path(world.scene, {.point = leg + (at_next ? 1 : 0), .to_next = worst != first && worst != last},
                world.path[worst].t_s,
                "is " + mm(most.over_m) + " beyond the workspace along " + (most.limit_m > 0.0 ? "+" : "-") +
                    "xyz"[most.axis] + " (limit " + mm(most.limit_m) +
                    "); move the object with [placement] or shorten the path");
}

Target target_at(const World& world, const PathPoint& at, const Stretch& stretch, cloud::Index seed) {
    const auto foot = world.surface->foot(world.pose(vec(at.at_m)), seed);
    if (!foot) {
        refuse_path(world.scene, stretch, at.t_s,
                    "has no smooth skin near it; choose points on one face of the scan");
    }
    const double above_m = world.scene.touch.tool_radius_m - at.depth_m;
    const Vector3d tool_m = foot->point_m + above_m * foot->normal;
    return {at.t_s, tool_m / world.scene.placement.position_scale, *foot};
}

PathPoint between(const PathPoint& a, const PathPoint& b, double share) {
    const Vector3d at = vec(a.at_m) + share * (vec(b.at_m) - vec(a.at_m));
    return {.t_s = a.t_s + share * (b.t_s - a.t_s),
            .at_m = {at.x(), at.y(), at.z()},
            .depth_m = a.depth_m + share * (b.depth_m - a.depth_m)};
}

/// The path is straight in the object's metres between its points; each moment is projected onto the scan. On
/// a curved one it is not straight in the workspace, so each target is checked; the hand goes straight from
/// one to the next, and the workspace is convex.
void resolve_path(World& world) {
    const std::vector<PathPoint>& points = world.scene.hand.path;
    if (points.empty()) return;
    cloud::Index seed = world.tree->nearest(world.pose(vec(points.front().at_m)));
    std::vector<std::size_t> target_of;  // each point's
    for (std::size_t leg = 0; leg < points.size(); ++leg) {
        const PathPoint& a = points[leg];
        const PathPoint& b = points[std::min(leg + 1, points.size() - 1)];
        const auto n = std::max<long>(1, std::lround((b.t_s - a.t_s) / PATH_STEP_S));
        target_of.push_back(world.path.size());
        for (long i = 0; i < (leg + 1 < points.size() ? n : 1); ++i) {
            const double share = static_cast<double>(i) / static_cast<double>(n);
            world.path.push_back(target_at(world, between(a, b, share), {leg, i > 0}, seed));
            seed = world.path.back().foot.nearest;
        }
    }
    const std::size_t end = target_of.size() - 1;
    for (std::size_t leg = 0; leg < std::max<std::size_t>(end, 1); ++leg) {
        check_reach(world, leg, target_of[leg], target_of[std::min(leg + 1, end)]);
    }
}

class Hash {
public:
    Hash() : state_(XXH64_createState()) { XXH64_reset(state_, 0); }
    ~Hash() { XXH64_freeState(state_); }
    Hash(const Hash&) = delete;
    Hash& operator=(const Hash&) = delete;
    void add(const void* bytes, std::size_t n) { XXH64_update(state_, bytes, n); }
    void add(double number) { add(&number, sizeof number); }
    void add(const std::vector<Vector3d>& points) { add(points.data(), points.size() * sizeof(Vector3d)); }
    [[nodiscard]] std::uint64_t value() const { return XXH64_digest(state_); }

private:
    XXH64_state_t* state_;
};

void check_size(const World& world) {
    const double side_m = box_of(world.cloud).longest_side_m();
    if (!(world.scene.patch.size_m > side_m * (1.0 + SIDE_SLACK))) return;
    refuse(where_among(world.scene, std::array<std::string, 2>{"patch.size_m", "object.size_m"}),
           "patch.size_m = " + mm(world.scene.patch.size_m) + " is larger than the object (" + mm(side_m) +
               " along its longest side); make the patch smaller or the object larger (object.size_m)");
}

}  // namespace

std::uint64_t source_hash_of(const World& world) {
    const Scene& s = world.scene;
    Hash hash;
    hash.add(world.cloud.points_m);
    hash.add(world.cloud.normals);
    hash.add(world.cloud.young_pa.data(), world.cloud.young_pa.size() * sizeof(double));
    for (const double number :
         {s.skin.thickness_m, s.skin.poisson, s.skin.foundation_n_per_m3,
          s.skin.model == Model::shell ? 1.0 : 0.0, s.patch.size_m,
          s.patch.projection == "azimuthal" ? 0.0 : 1.0, s.solver.tolerance,
          static_cast<double>(s.solver.table_nodes), s.touch.tool_radius_m,
          s.touch.law == Law::potential ? 0.0 : 1.0, s.placement.position_scale, s.placement.force_scale}) {
        hash.add(number);
    }
    return hash.value();
}

contact::Surface World::another_surface() const {
    return {cloud, *graph, surface->support_m()};
}

std::unique_ptr<World> build(const Scene& scene) {
    const std::filesystem::path file = points_file(scene);
    check_axes(scene, file);
    auto world = build(scene, cloud::read(file));
    world->object_name = file.filename().string();
    return world;
}

std::unique_ptr<World> build(const Scene& scene, cloud::Cloud cloud) {
    auto world = std::make_unique<World>();
    world->scene = scene;
    world->cloud = std::move(cloud);
    Hash as_read;
    as_read.add(world->cloud.points_m);
    as_read.add(world->cloud.normals);
    world->object_hash = as_read.value();
    turn_axes(scene.object, world->cloud);
    scale(scene.object, world->cloud);
    check_size(*world);
    index(*world);
    drop_other_side(*world);
    world->cloud.young_pa.assign(world->cloud.points_m.size(), scene.skin.young_pa);
    for (std::size_t i = 0; i < scene.changes.size(); ++i) apply(scene.changes[i], *world, i);
    place(*world);
    index(*world);
    world->material = {.thickness_m = scene.skin.thickness_m,
                       .poisson = scene.skin.poisson,
                       .foundation_n_per_m3 = scene.skin.foundation_n_per_m3,
                       .shell = scene.skin.model == Model::shell,
                       .patch_size_m = scene.patch.size_m,
                       .projection = scene.patch.projection == "azimuthal" ? chart::Projection::azimuthal
                                                                           : chart::Projection::gall_peters,
                       .spacing_m = world->spacing_m,
                       .tolerance = scene.solver.tolerance};
    resolve_path(*world);
    world->source_hash = source_hash_of(*world);
    return world;
}

}  // namespace palpate::scene

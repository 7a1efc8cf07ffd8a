#include "host/plate/iterative/transfer.hpp"

#include <algorithm>

namespace palpate::plate {
namespace {

using Eigen::Index;

constexpr double NEAR = 9.0 / 16.0, FAR = -1.0 / 16.0;  ///< of the cubic through four nodes, half way

/// Deflection one node beyond an edge from that at the edge and the two next to it.
std::array<double, 3> ghost(Edge edge) {
    switch (edge) {
        case Edge::clamped:
            return {0.0, 1.0, 0.0};
        case Edge::supported:
            return {0.0, -1.0, 0.0};
        case Edge::free:
            return {3.0, -3.0, 1.0};
    }
    return {};
}

}  // namespace

bool can_coarsen(Index nx, Index nz) {
    constexpr Index NODES_MIN = 9;
    return nx % 2 == 1 && nz % 2 == 1 && nx >= NODES_MIN && nz >= NODES_MIN;
}

void weigh_fully(const Eigen::Ref<const Eigen::ArrayXXd>& fine, Eigen::Ref<Eigen::ArrayXXd> coarse,
                 Eigen::Ref<Eigen::ArrayXXd> room) {
    const auto mean = [](double before, double centre, double after) {
        return 0.5 * centre + 0.25 * (before + after);
    };
    const Index nx = coarse.rows(), nz = coarse.cols();
    for (Index iz = 0; iz < fine.cols(); ++iz) {
        const double* const from = &fine.coeffRef(0, iz);
        double* const to = room.col(iz).data();
        to[0] = 0.5 * (from[0] + from[1]);
        for (Index i = 1; i + 1 < nx; ++i) to[i] = mean(from[2 * i - 1], from[2 * i], from[2 * i + 1]);
        to[nx - 1] = 0.5 * (from[2 * nx - 2] + from[2 * nx - 3]);
    }
    for (Index iz = 0; iz < nz; ++iz) {
        const Index before = iz == 0 ? 1 : 2 * iz - 1, after = iz == nz - 1 ? 2 * iz - 1 : 2 * iz + 1;
        const bool end = iz == 0 || iz == nz - 1;
        for (Index i = 0; i < nx; ++i) {
            coarse(i, iz) = end ? 0.5 * (room(i, 2 * iz) + room(i, before))
                                : mean(room(i, before), room(i, 2 * iz), room(i, after));
        }
    }
}

Transfer::Transfer(const Layout& fine, const Layout& coarse, const std::array<Edge, 4>& edges)
    : fine_(fine),
      coarse_(coarse),
      moving_(coarse.nx, coarse.nz, edges),
      edges_(edges),
      row_(static_cast<std::size_t>(coarse.stride()), 0.0) {
    for (Index iz = 0; iz < fine.nz; ++iz) taps_.push_back(taps(iz));
}

Transfer::Taps Transfer::taps(Index fine_row) const {
    const Index n = coarse_.nz, below = fine_row / 2;
    Taps taps{std::clamp<Index>(below - 1, 0, n - 4), {}};
    const auto add = [&](Index row, double weight) {
        taps.weight.at(static_cast<std::size_t>(row - taps.first)) += weight;
    };
    if (fine_row % 2 == 0) {
        add(below, 1.0);
        return taps;
    }
    add(below, NEAR);
    add(below + 1, NEAR);
    const std::array<Index, 2> far{below - 1, below + 2};
    for (const Index row : far) {
        if (row >= 0 && row < n) {
            add(row, FAR);
            continue;
        }
        const auto beyond = ghost(row < 0 ? edges_[2] : edges_[3]);
        for (Index k = 0; k < 3; ++k)
            add(row < 0 ? k : n - 1 - k, FAR * beyond.at(static_cast<std::size_t>(k)));
    }
    return taps;
}

void Transfer::prolong(const double* coarse, double* fine) {
    const Index n = coarse_.nx;
    const auto low = ghost(edges_[0]), high = ghost(edges_[1]);
    double* const __restrict t = row_.data() + Layout::PADDING;
    for (Index iz = 0; iz < fine_.nz; ++iz) {
        const Taps& taps = taps_[static_cast<std::size_t>(iz)];
        const double* const c = coarse + coarse_.at(0, taps.first);
        const Index s = coarse_.stride();
        const auto [w0, w1, w2, w3] = taps.weight;
        for (Index i = 0; i < n; ++i)
            t[i] = (w0 * c[i] + w1 * c[i + s]) + (w2 * c[i + 2 * s] + w3 * c[i + 3 * s]);
        t[-1] = (low[0] * t[0] + low[1] * t[1]) + low[2] * t[2];
        t[n] = (high[0] * t[n - 1] + high[1] * t[n - 2]) + high[2] * t[n - 3];
        double* const __restrict to = fine + fine_.at(0, iz);
        for (Index i = 0; i + 1 < n; ++i) {
            to[2 * i] += t[i];
            to[2 * i + 1] += NEAR * (t[i] + t[i + 1]) + FAR * (t[i - 1] + t[i + 2]);
        }
        to[2 * n - 2] += t[n - 1];
    }
}

void Transfer::restrict_from(const double* fine, double scale, double* coarse) {
    const Index n = coarse_.nx;
    const auto low = ghost(edges_[0]), high = ghost(edges_[1]);
    std::fill(coarse, coarse + coarse_.size(), 0.0);
    double* const __restrict t = row_.data() + Layout::PADDING;
    for (Index iz = 0; iz < fine_.nz; ++iz) {
        const double* const __restrict r = fine + fine_.at(0, iz);  // r[-3] and so on are padding, 0
        for (Index i = 0; i < n; ++i) {
            t[i] = scale *
                   (r[2 * i] + (NEAR * (r[2 * i - 1] + r[2 * i + 1]) + FAR * (r[2 * i - 3] + r[2 * i + 3])));
        }
        const double before = scale * FAR * r[1], after = scale * FAR * r[2 * n - 3];
        for (Index k = 0; k < 3; ++k) {
            t[k] += low.at(static_cast<std::size_t>(k)) * before;
            t[n - 1 - k] += high.at(static_cast<std::size_t>(k)) * after;
        }
        const Taps& taps = taps_[static_cast<std::size_t>(iz)];
        double* __restrict c = coarse + coarse_.at(0, taps.first);
        for (const double weight : taps.weight) {
            if (weight != 0.0) {
                for (Index i = 0; i < n; ++i) c[i] += weight * t[i];
            }
            c += coarse_.stride();
        }
    }
    for (Index iz = 0; iz < coarse_.nz; ++iz) {
        for (Index ix = 0; ix < n; ++ix) {
            if (!moving_.holds(ix, iz)) coarse[coarse_.at(ix, iz)] = 0.0;
        }
    }
}

}  // namespace palpate::plate

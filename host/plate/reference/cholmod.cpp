#include "host/plate/reference/cholmod.hpp"

#include <cholmod.h>
#include <dlfcn.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "host/plate/reference/bending.hpp"
#include "host/plate/reference/request.hpp"

extern "C" void dgemm_();

namespace palpate::reference {
namespace {

constexpr std::size_t REPEATS_MIN = 3, REPEATS_MAX = 201;

double now_s() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Row and column of the lower half of K.
using Place = std::pair<std::size_t, std::size_t>;

/// K = sum over nodes of D times a pattern that the grid alone decides: pattern once, sum for every D.
class Assembly {
public:
    explicit Assembly(const Grid& grid) : grid_(grid), unknowns_((grid.plate.nx - 2) * (grid.plate.nz - 2)) {
        for (std::size_t ix = 0; ix < grid.plate.nx; ++ix) {
            for (std::size_t iz = 0; iz < grid.plate.nz; ++iz) add_node(ix, iz);
        }
        for (std::size_t ix = 0; ix + 1 < grid.plate.nx; ++ix) {
            for (std::size_t iz = 0; iz + 1 < grid.plate.nz; ++iz) add_cell(ix, iz);
        }
        column_.assign(unknowns_ + 1, 0);
        for (const auto& [place, shares] : shares_of_) {  // by column, then by row
            ++column_[place.first + 1];
            row_.push_back(static_cast<int>(place.second));
            begin_.push_back(share_.size());
            share_.insert(share_.end(), shares.begin(), shares.end());
        }
        begin_.push_back(share_.size());
        for (std::size_t c = 0; c < unknowns_; ++c) column_[c + 1] += column_[c];
        shares_of_.clear();
    }

    [[nodiscard]] std::size_t unknowns() const { return unknowns_; }
    [[nodiscard]] std::size_t entries() const { return row_.size(); }
    [[nodiscard]] std::size_t unknown(std::size_t ix, std::size_t iz) const {
        return grid_.on_edge(ix, iz) ? ZERO : (ix - 1) * (grid_.plate.nz - 2) + (iz - 1);
    }
    void put_pattern(cholmod_sparse& k) const {
        std::copy(column_.begin(), column_.end(), static_cast<int*>(k.p));
        std::copy(row_.begin(), row_.end(), static_cast<int*>(k.i));
    }
    /// `weight` as of weights().
    void put_values(const std::vector<double>& weight, cholmod_sparse& k) const {
        auto* const values = static_cast<double*>(k.x);
        for (std::size_t e = 0; e < row_.size(); ++e) {
            double sum = 0.0;
            for (std::size_t s = begin_[e]; s < begin_[e + 1]; ++s)
                sum += share_[s].factor * weight[share_[s].of];
            values[e] = sum;
        }
    }
    /// D over its largest at the nodes, then the foundation there.
    [[nodiscard]] std::vector<double> weights() const {
        std::vector<double> weight(2 * grid_.nodes(), 0.0);
        const double side2 = grid_.plate.size_x_m * grid_.plate.size_x_m;
        for (std::size_t n = 0; n < grid_.nodes(); ++n) {
            weight[n] = grid_.plate.rigidity_n_m[n] / grid_.rigidity_max_n_m;
            if (!grid_.plate.foundation_n_per_m3.empty()) {
                weight[grid_.nodes() + n] =
                    grid_.plate.foundation_n_per_m3[n] * side2 * side2 / grid_.rigidity_max_n_m;
            }
        }
        return weight;
    }

private:
    struct Share {
        double factor;
        std::size_t of;  ///< index of the weight
    };

    /// factor weight(of) first second, symmetric.
    void add(const Terms& first, const Terms& second, double factor, std::size_t of) {
        for (const Term& a : first) {
            for (const Term& b : second) {
                if (a.unknown == ZERO || b.unknown == ZERO || b.unknown > a.unknown) continue;
                std::vector<Share>& shares = shares_of_[{b.unknown, a.unknown}];
                const auto own = std::find_if(shares.begin(), shares.end(),
                                              [&](const Share& share) { return share.of == of; });
                const double value = factor * a.factor * b.factor;
                if (own == shares.end()) {
                    shares.push_back({value, of});
                } else {
                    own->factor += value;
                }
            }
        }
    }

    /// D [w_xx^2 + w_zz^2 + 2 nu w_xx w_zz] and the foundation; at an edge the ghost mirrors.
    void add_node(std::size_t ix, std::size_t iz) {
        const Plate& plate = grid_.plate;
        const bool edge_x = ix == 0 || ix + 1 == plate.nx, edge_z = iz == 0 || iz + 1 == plate.nz;
        if (edge_x && edge_z) return;
        const double area = grid_.hx * grid_.hz * (edge_x || edge_z ? 0.5 : 1.0);
        const auto curvature = [&](std::size_t i, std::size_t last, auto&& at, double h) {
            const double f = 1.0 / (h * h);
            if (i == 0) return Terms{{at(std::size_t{1}), 2.0 * f}};
            if (i == last) return Terms{{at(last - 1), 2.0 * f}};
            return Terms{{at(i - 1), f}, {at(i), -2.0 * f}, {at(i + 1), f}};
        };
        const auto along_x = [&](std::size_t i) { return unknown(i, iz); };
        const auto along_z = [&](std::size_t i) { return unknown(ix, i); };
        const Terms x = edge_z ? Terms{} : curvature(ix, plate.nx - 1, along_x, grid_.hx);
        const Terms z = edge_x ? Terms{} : curvature(iz, plate.nz - 1, along_z, grid_.hz);
        const std::size_t node = grid_.node(ix, iz);
        add(x, x, area, node);
        add(z, z, area, node);
        add(x, z, area * plate.poisson, node);
        add(z, x, area * plate.poisson, node);
        const Terms own{{unknown(ix, iz), 1.0}};
        add(own, own, area, grid_.nodes() + node);
    }

    /// 2 (1 - nu) D_c w_xz^2, D_c the mean of the corners.
    void add_cell(std::size_t ix, std::size_t iz) {
        const Terms corners{{unknown(ix, iz), 1.0},
                            {unknown(ix + 1, iz), -1.0},
                            {unknown(ix, iz + 1), -1.0},
                            {unknown(ix + 1, iz + 1), 1.0}};
        const double factor = 2.0 * (1.0 - grid_.plate.poisson) / (grid_.hx * grid_.hz) / 4.0;
        for (const std::size_t jx : {ix, ix + 1}) {
            for (const std::size_t jz : {iz, iz + 1}) add(corners, corners, factor, grid_.node(jx, jz));
        }
    }

    const Grid& grid_;
    std::size_t unknowns_;
    std::map<Place, std::vector<Share>> shares_of_;  ///< by column and row, while it is made
    std::vector<int> column_, row_;
    std::vector<std::size_t> begin_;
    std::vector<Share> share_;
};

/// CHOLMOD's objects, freed in the end.
class Cholmod {
public:
    Cholmod(const Assembly& assembly, std::size_t contact, int kind)
        : assembly_(assembly), contact_(contact) {
        cholmod_start(&common_);
        common_.supernodal = kind;
        const std::size_t n = assembly.unknowns();
        k_ = cholmod_allocate_sparse(n, n, assembly.entries(), 1, 1, -1, CHOLMOD_REAL, &common_);
        b_ = cholmod_zeros(n, 1, CHOLMOD_REAL, &common_);
        require(k_ != nullptr && b_ != nullptr, "no memory");
        static_cast<double*>(b_->x)[contact] = 1.0;
        assembly.put_pattern(*k_);
    }
    ~Cholmod() {
        cholmod_free_dense(&x_, &common_);
        cholmod_free_dense(&y_, &common_);
        cholmod_free_dense(&e_, &common_);
        cholmod_free_dense(&b_, &common_);
        cholmod_free_factor(&l_, &common_);
        cholmod_free_sparse(&k_, &common_);
        cholmod_finish(&common_);
    }
    Cholmod(const Cholmod&) = delete;
    Cholmod& operator=(const Cholmod&) = delete;

    [[nodiscard]] cholmod_sparse* matrix() { return k_; }
    /// Seconds.
    double analyse() {
        const double begin_s = now_s();
        l_ = cholmod_analyze(k_, &common_);
        require(l_ != nullptr, "the analysis failed");
        return now_s() - begin_s;
    }
    /// From D to the compliance, in grid units.
    double compliance(const std::vector<double>& weight) {
        assembly_.put_values(weight, *k_);
        require(cholmod_factorize(k_, l_, &common_) != 0 && common_.status == CHOLMOD_OK,
                "the factor failed: not positive definite");
        require(cholmod_solve2(CHOLMOD_A, l_, b_, nullptr, &x_, nullptr, &y_, &e_, &common_) != 0,
                "the solution failed");
        return static_cast<const double*>(x_->x)[contact_];
    }
    [[nodiscard]] std::size_t memory_peak_bytes() const { return common_.memory_usage; }

private:
    static void require(bool good, const char* what) {
        if (!good) throw std::runtime_error(std::string("CHOLMOD: ") + what);
    }

    const Assembly& assembly_;
    std::size_t contact_;
    cholmod_common common_{};
    cholmod_sparse* k_ = nullptr;
    cholmod_dense *b_ = nullptr, *x_ = nullptr, *y_ = nullptr, *e_ = nullptr;
    cholmod_factor* l_ = nullptr;
};

nlohmann::json timed(const Grid& grid, const Assembly& assembly, int kind, double budget_s) {
    const Plate& plate = grid.plate;
    const std::vector<double> weight = assembly.weights();
    Cholmod cholmod(assembly, assembly.unknown(plate.contact_ix, plate.contact_iz), kind);
    assembly.put_values(weight, *cholmod.matrix());
    const double begin_s = now_s();
    const double analysis_s = cholmod.analyse();
    const double c = cholmod.compliance(weight);
    const double first_s = now_s() - begin_s;
    std::vector<double> walls_s;
    while (walls_s.size() < REPEATS_MAX && (walls_s.size() < REPEATS_MIN || now_s() - begin_s < budget_s)) {
        const double from_s = now_s();
        if (cholmod.compliance(weight) != c) throw std::runtime_error("CHOLMOD: two answers to one question");
        walls_s.push_back(now_s() - from_s);
    }
    std::sort(walls_s.begin(), walls_s.end());
    const auto quartile = [&](std::size_t q) { return walls_s[(walls_s.size() - 1) * q / 4]; };
    return {{"compliance_m_per_n", c * plate.size_x_m * plate.size_x_m / grid.rigidity_max_n_m},
            {"analysis_s", analysis_s},
            {"first_s", first_s},
            {"quartile_1_s", quartile(1)},
            {"median_s", quartile(2)},
            {"quartile_3_s", quartile(3)},
            {"repeats", walls_s.size()},
            {"memory_peak_bytes", cholmod.memory_peak_bytes()}};
}

/// The file that dgemm comes from.
std::string blas_library() {
    Dl_info info{};
    if (dladdr(reinterpret_cast<void*>(&dgemm_), &info) == 0 || info.dli_fname == nullptr) return "unknown";
    std::error_code none;
    const auto real = std::filesystem::canonical(info.dli_fname, none);
    return none ? info.dli_fname : real.string();
}

}  // namespace

std::string cholmod_text(std::istream& in) {
    double budget_s = 0.2;
    Plate plate;
    try {
        nlohmann::json request = nlohmann::json::parse(in);
        if (request.is_object()) {
            budget_s = request.value("budget_s", budget_s);
            request.erase("budget_s");
        }
        std::istringstream rest(request.dump());
        plate = read_plate(rest);
    } catch (const nlohmann::json::exception& error) {
        throw BadRequest(error.what());
    }
    if (!(budget_s > 0.0 && budget_s <= 3600.0)) throw BadRequest("budget_s: must lie between 0 and 3600");
    const Grid grid(plate);
    const Assembly assembly(grid);
    return nlohmann::json{{"simplicial", timed(grid, assembly, CHOLMOD_SIMPLICIAL, budget_s)},
                          {"supernodal", timed(grid, assembly, CHOLMOD_SUPERNODAL, budget_s)},
                          {"blas", blas_library()}}
        .dump();
}

}  // namespace palpate::reference

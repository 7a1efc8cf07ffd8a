#include "host/scene/plate_keys.hpp"

namespace palpate::scene {
namespace {

constexpr const char* HEAD = R"(# Every key of a plate file

Generated from the table of keys in `host/scene/plate_keys.cpp`; a test holds the two together (`test_scene "[.write-plate]"` writes it).

`palpate solve PLATE.toml` tells how far a plate of one's own gives way under a push, and how sure that is. The smallest plate file:

```
[plate]
size_m  = [0.04, 0.04]
poisson = 0.3

[rigidity]
value_n_m = 0.03
```

Every number carries its unit in its key; places are (x, z) in m from the plate's corner. Any other key is refused, with the nearest known one named; errors read `file:line: what is wrong; what would be right`.
`--set section.key=value` replaces or adds one value, read as TOML; a bare word is a string. Examples: [sim/scenes/plates](../sim/scenes/plates).
)";

constexpr const char* TAIL = R"(
## Files of numbers

Row i, column j of a file belongs to x_i, z_j; first and last lie on the edges. 4097 rows and columns at most.

- `.csv`: numbers with commas between them, as many in each row, `.` decimals; no header, no comments.
- `.npy`: two dimensions; `<f8`, `<f4`, `<i8`, `<i4` or big-endian, C or Fortran order, format 1.0 or 2.0: what `numpy.save` writes. `output.field` is `<f8` in C order.

`output.field` has as many rows and columns as `plate.nodes`. It is written beside its place and renamed, as is the picture; an earlier one is replaced. Both go to the folder of the plate file, or to `--out DIR`.

## What is told

`--json` prints one document on stdout, words on stderr; without it the words are on stdout. `--quiet` leaves the words away; alone it prints the compliance in m/N and nothing else.

| key | meaning |
|---|---|
| `schema` | `palpate.solve/1` |
| `palpate`, `build`, `command`, `started_utc`, `file` | what made this, when, from what |
| `load`, `points_m` | as in the plate file, the middle of the plate filled in |
| `compliance_m_per_n` | deflection at the load per newton; over a disc, its mean |
| `deflection_m` | at each of `points_m`, under `force_n` |
| `lower_m_per_n`, `upper_m_per_n` | certified: the continuum's compliance lies between them |
| `estimated_relative_error` | of `compliance_m_per_n` about the continuum |
| `method`, `why`, `kernel`, `nodes`, `iterations`, `residual` | how it was solved; `iterations` 0: directly |
| `wall_s` | time that solving took |
| `warning` | words, or null |
| `status` | `solved`, `not-converged` or `diverged` |
| `field`, `plot` | files that were written |

A number or file that there is not is `null`, and its sibling `..._why` says why. Exit codes: 0 done; 1 no number (a method that diverged or did not converge, a guard) or no picture; 2 bad input; 130 interrupted.
)";

std::string limits(const PlateKey& key) {
    if (*key.choices != '\0') return either(split(key.choices, '|'));
    const std::string range = key.range.words();
    return range.empty() || *key.unit == '\0' ? range + key.unit : key.unit + std::string(", ") + range;
}

std::string row(const PlateKey& key) {
    const bool required = *key.otherwise == '\0';
    const std::string limit = limits(key);
    return "| `" + split(key.name, '.')[1] + "` | " +
           (required ? "required, such as `" + std::string(key.example) + "`" : key.otherwise) + " | " +
           key.about + (limit.empty() ? "" : " (" + limit + ")") + " |\n";
}

}  // namespace

std::string plate_markdown() {
    std::string out = HEAD;
    for (const std::string& section : plate_sections()) {
        out += "\n## [" + section + "]\n\n| key | default | meaning |\n|---|---|---|\n";
        for (const PlateKey& key : plate_keys()) {
            if (split(key.name, '.')[0] == section) out += row(key);
        }
    }
    return out + TAIL;
}

}  // namespace palpate::scene

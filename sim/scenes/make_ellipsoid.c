/// palpate-ellipsoid FILE.ply: the paper's simulated object, an ellipsoid of 40 000 points (here 48 x 36 x 30
/// mm), for machines without the bunny. Points on a Fibonacci spiral of the unit sphere, stretched; metres;
/// ascii PLY.
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { N_POINTS = 40000, EXIT_BAD_INPUT = 2 };

static const double HALF_AXIS_M[3] = {0.024, 0.018, 0.015};
// Cosine and sine of the golden angle pi (3 - sqrt 5): each point turns on by it.
static const double TURN_COS = -0.7373688780783197, TURN_SIN = 0.6754902942615238;

static void write_points(FILE* out) {
    (void)fprintf(out, "ply\nformat ascii 1.0\nelement vertex %d\n", N_POINTS);
    (void)fprintf(out, "property double x\nproperty double y\nproperty double z\nend_header\n");
    double c = 1.0, s = 0.0;
    for (int i = 0; i < N_POINTS; ++i) {
        const double z = 1.0 - (2.0 * i + 1.0) / N_POINTS, around = sqrt(1.0 - z * z);
        (void)fprintf(out, "%.9f %.9f %.9f\n", HALF_AXIS_M[0] * around * c, HALF_AXIS_M[1] * around * s,
                      HALF_AXIS_M[2] * z);
        const double turned = c * TURN_COS - s * TURN_SIN;
        s = s * TURN_COS + c * TURN_SIN;
        c = turned;
    }
}

int main(int argc, char** argv) {
    if (argc != 2 || strcmp(argv[1], "--help") == 0) {
        (void)fprintf(
            argc == 2 ? stdout : stderr,
            "palpate-ellipsoid FILE.ply: writes an ellipsoid of %d points, 48 x 36 x 30 mm, in metres.\n",
            N_POINTS);
        return argc == 2 ? 0 : EXIT_BAD_INPUT;
    }
    FILE* out = fopen(argv[1], "w");
    if (!out) {
        perror(argv[1]);
        return EXIT_BAD_INPUT;
    }
    write_points(out);
    const int failed = ferror(out);
    if (fclose(out) != 0 || failed) {
        perror(argv[1]);
        return EXIT_BAD_INPUT;
    }
    return 0;
}

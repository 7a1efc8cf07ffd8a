// palpate-falcon list and firmware.
#include "firmware/app/falcon_cli.h"

static const char* access_word(pal_usb_problem access) {
    switch (access) {
        case PAL_USB_OK:
            return "ok";
        case PAL_USB_DENIED:
            return "denied";
        case PAL_USB_BUSY:
            return "busy";
        case PAL_USB_NONE:
            return "gone";
        case PAL_USB_FAILED:
            break;
    }
    return "failed";
}

// `words`: why there is no list; "" when there is one.
static void print_json(const pal_usb_found* found, int n, const char* words) {
    (void)printf("{\"schema\": \"palpate.falcon_list/1\", \"words\": ");
    pal_cli_json_text(stdout, words);
    (void)printf(", \"devices\": [");
    for (int i = 0; i < n; ++i) {
        char why[PAL_USB_WORDS_BYTES];
        pal_usb_explain(found[i].access, &found[i], why);
        (void)printf("%s\n  {\"serial\": ", i > 0 ? "," : "");
        pal_cli_json_text(stdout, found[i].serial);
        (void)printf(", \"product\": ");
        pal_cli_json_text(stdout, found[i].product);
        (void)printf(", \"node\": ");
        pal_cli_json_text(stdout, found[i].node);
        (void)printf(", \"speed_mbit_per_s\": %u, \"access\": \"%s\", \"user\": ", found[i].speed_mbit_per_s,
                     access_word(found[i].access));
        pal_cli_json_text(stdout, found[i].user);
        (void)printf(", \"words\": ");
        pal_cli_json_text(stdout, why);
        (void)printf("}");
    }
    (void)printf("]}\n");
}

static void print_words(const pal_usb_found* found, int n) {
    for (int i = 0; i < n; ++i) {
        char why[PAL_USB_WORDS_BYTES];
        pal_usb_explain(found[i].access, &found[i], why);
        (void)printf("%-16s %-16s %s  %s%s\n", found[i].serial, found[i].product, found[i].node,
                     found[i].access == PAL_USB_OK ? "ready to be used" : why,
                     found[i].speed_mbit_per_s > 12 ? "  (not at full speed: is it a Falcon?)" : "");
    }
}

int pal_falcon_list(const pal_falcon_options* options) {
    pal_usb_found found[PAL_USB_DEVICES_MAX];
    char why[PAL_USB_WORDS_BYTES];
    const int n = pal_usb_find(found, why);
    if (options->json)
        print_json(found, n, n < 0 ? why : "");
    else
        print_words(found, n);
    if (n == 0) {
        const pal_usb_found none = {.serial = ""};
        pal_usb_explain(PAL_USB_NONE, &none, why);
    }
    if (n <= 0) (void)fprintf(stderr, "palpate-falcon: %s\n", why);
    return n > 0 ? PAL_EXIT_DONE : PAL_EXIT_DEVICE;
}

int pal_falcon_firmware(const pal_falcon_options* options) {
    static pal_firmware_file file;
    char why[PAL_FIRMWARE_WORDS_BYTES] = "";
    const bool good = pal_firmware_read(options->firmware, &file, why);
    if (!good) (void)fprintf(stderr, "palpate-falcon: %s\n", why);
    if (options->json) {
        (void)printf("{\"schema\": \"palpate.falcon_firmware/1\", \"good\": %s, \"path\": ",
                     good ? "true" : "false");
        pal_cli_json_text(stdout, file.path);
        (void)printf(", \"n_bytes\": %zu, \"sha256\": \"%s\", \"name\": ", file.n_bytes, file.sha256);
        pal_cli_json_text(stdout, file.name != NULL ? file.name : "");
        (void)printf(", \"words\": ");
        pal_cli_json_text(stdout, why);
        (void)printf("}\n");
    } else if (good) {
        (void)printf("%s: %zu bytes, whole, %s, SHA-256 %s\n", file.path, file.n_bytes,
                     file.name != NULL ? file.name : "none of the published images", file.sha256);
    }
    return good ? PAL_EXIT_DONE : PAL_EXIT_ARGUMENTS;
}

#include "common/err.h"

const char* pal_err_words(pal_err err) {
    switch (err) {
        case PAL_OK:
            return "no error";
        case PAL_ERR_MAGIC:
            return "not one of our structures";
        case PAL_ERR_ENDIAN:
            return "written by a machine of the other byte order";
        case PAL_ERR_ABI:
            return "made by another version of the layout";
        case PAL_ERR_SIZE:
            return "a size disagrees with the layout";
        case PAL_ERR_CRC:
            return "the bytes changed after they were sealed";
        case PAL_ERR_NOT_FINITE:
            return "NaN or infinity where a number belongs";
        case PAL_ERR_RANGE:
            return "a number outside what is safe";
        case PAL_ERR_IO:
            return "the system refused";
    }
    return "an error without a name";
}

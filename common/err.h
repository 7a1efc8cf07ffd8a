/// What can go wrong while something is set up. The tick itself cannot fail: it answers with fault bits.
#pragma once
#ifdef __cplusplus
extern "C" {
#endif

typedef enum pal_err {
    PAL_OK = 0,
    PAL_ERR_MAGIC = -1,       ///< not one of our structures
    PAL_ERR_ENDIAN = -2,      ///< written by a machine of the other byte order
    PAL_ERR_ABI = -3,         ///< made by another version of the layout
    PAL_ERR_SIZE = -4,        ///< a size disagrees with the layout
    PAL_ERR_CRC = -5,         ///< the bytes changed after they were sealed
    PAL_ERR_NOT_FINITE = -6,  ///< NaN or infinity where a number belongs
    PAL_ERR_RANGE = -7,       ///< a number outside what is safe
    PAL_ERR_IO = -8           ///< the system refused; errno says more
} pal_err;

/// A short sentence for a person; never NULL.
const char* pal_err_words(pal_err err);

#ifdef __cplusplus
}
#endif

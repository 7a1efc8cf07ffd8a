/// USB traffic as a file that Wireshark reads: pcap with Linux' usbmon headers of 64 bytes (link type 220).
/// What is written is what this program handed to libusb and got back from it.
#pragma once
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#ifdef __cplusplus
extern "C" {
#endif

enum { PAL_PCAP_LINK_TYPE = 220, PAL_PCAP_HEADER_BYTES = 64, PAL_PCAP_FILE_HEADER_BYTES = 24 };

typedef struct pal_pcap {
    FILE* file;
    bool failed;  ///< a write failed, the disk is full perhaps: nothing more is written
} pal_pcap;

typedef enum pal_pcap_event { PAL_PCAP_SUBMIT = 'S', PAL_PCAP_COMPLETE = 'C' } pal_pcap_event;

/// One event. Of an OUT the data stand in the submission, of an IN in the completion, as usbmon has it.
typedef struct pal_pcap_record {
    uint64_t id;       ///< the same for a submission and its completion
    uint64_t time_us;  ///< since 1970
    pal_pcap_event event;
    uint8_t endpoint;  ///< 0x81, 0x02; 0 for a control transfer out
    uint8_t bus, address;
    int32_t status;        ///< 0, or a negative errno value; of a submission -115, in progress
    uint32_t n_bytes;      ///< wanted or moved
    const uint8_t* setup;  ///< 8 bytes in the submission of a control transfer, else NULL
    const uint8_t* data;   ///< NULL: none in this event
} pal_pcap_record;

/// Makes the file. False with errno.
bool pal_pcap_open(pal_pcap* pcap, const char* path);
/// Nothing for NULL, a closed or a failed file.
void pal_pcap_write(pal_pcap* pcap, const pal_pcap_record* record);
/// False when something could not be written.
bool pal_pcap_close(pal_pcap* pcap);

#ifdef __cplusplus
}
#endif

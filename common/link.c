#include "common/link.h"

#include <string.h>

#include "common/atomic.h"

static const uint32_t MAGIC_SWAPPED = 0x4C494E4BU;  // PAL_LINK_MAGIC as the other byte order sees it

void pal_link_init(pal_link* link, uint32_t nonce) {
    memset(link, 0, sizeof *link);
    pal_table_ring_init(&link->tables);
    pal_state_ring_init(&link->ticks);
    pal_link_header* header = &link->header;
    header->endian = PAL_LINK_ENDIAN;
    header->abi = PAL_LINK_ABI;
    header->n_bytes = (uint32_t)sizeof(pal_link);
    header->table_bytes = (uint32_t)sizeof(pal_table);
    header->tick_bytes = (uint32_t)sizeof(pal_tick);
    header->n_slots = PAL_TABLE_SLOTS;
    header->n_ticks = PAL_STATE_RING_TICKS;
    header->nonce = nonce;
    pal_link_store(&header->magic, PAL_LINK_MAGIC);
}

pal_err pal_link_check(const pal_link* link, size_t n_bytes) {
    const pal_link_header* header = &link->header;
    if (n_bytes < sizeof *header) return PAL_ERR_SIZE;
    const uint32_t magic = pal_link_load(&header->magic);
    if (magic == MAGIC_SWAPPED) return PAL_ERR_ENDIAN;
    if (magic != PAL_LINK_MAGIC) return PAL_ERR_MAGIC;
    if (header->endian != PAL_LINK_ENDIAN) return PAL_ERR_ENDIAN;
    if (header->abi != PAL_LINK_ABI) return PAL_ERR_ABI;
    if (header->n_bytes != sizeof(pal_link) || n_bytes < sizeof(pal_link) ||
        header->table_bytes != sizeof(pal_table) || header->tick_bytes != sizeof(pal_tick) ||
        header->n_slots != PAL_TABLE_SLOTS || header->n_ticks != PAL_STATE_RING_TICKS) {
        return PAL_ERR_SIZE;
    }
    return PAL_OK;
}

uint32_t pal_link_load(const uint32_t* word) {
    return pal_atomic_load_acquire(word);
}

void pal_link_store(uint32_t* word, uint32_t value) {
    pal_atomic_store_release(word, value);
}

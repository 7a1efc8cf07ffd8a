// One open device of a program under the preload library: submit, reap, discard and calls over sockets, and a
// pipe whose write end stands for the usbfs node: writable means there is something to reap, an error means
// unplugged.
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/uio.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include "sim/usb/preload.h"

enum { FDS_MAX = 65536, URBS_MAX = 1024, SETUP_BYTES = 8, PIPE_BYTES_MIN = 1, ENDPOINT_IN = 0x80 };

typedef struct pending {
    struct usbdevfs_urb* urb;  // NULL: free
    uint64_t tag;
} pending;

struct pal_preload_link {
    int fd;     // write end of the pipe: the program's descriptor
    int urbs;   // socket
    int calls;  // socket
    uint16_t out_endpoints, in_endpoints;
    char node[PAL_PRELOAD_PATH_MAX];
    pthread_mutex_t urb_mutex;   // of pending, next_tag
    pthread_mutex_t reap_mutex;  // of message
    pthread_mutex_t call_mutex;
    pending pending[URBS_MAX];
    uint64_t next_tag;
    uint8_t message[sizeof(pal_wire_urb) + PAL_WIRE_DATA_MAX];
};

static pal_preload_link* g_links[FDS_MAX];  // by descriptor; read and written atomically

static int fail(int reason) {
    errno = reason;
    return -1;
}

pal_preload_link* pal_preload_link_of(int fd) {
    return fd >= 0 && fd < FDS_MAX ? __atomic_load_n(&g_links[fd], __ATOMIC_ACQUIRE) : NULL;
}

const char* pal_preload_link_node(const pal_preload_link* link) {
    return link->node;
}

static time_t now_s(void) {
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return now.tv_sec;
}

/// Whether only a signal ended a wait, which began at `begin_s`, before its time.
static bool once_more(time_t begin_s) {
    return errno == EINTR && now_s() - begin_s <= PAL_WIRE_PATIENCE_S;
}

int pal_preload_connect(const char* path) {
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    const size_t n = strlen(path);
    if (n >= sizeof address.sun_path) return fail(ENAMETOOLONG);
    memcpy(address.sun_path, path, n + 1);
    const int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    if (fd < 0) return -1;
    const struct timeval patience = {PAL_WIRE_PATIENCE_S, 0};
    (void)setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    (void)setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
    const time_t begin_s = now_s();
    int code;
    do code = connect(fd, (const struct sockaddr*)&address, sizeof address);
    while (code != 0 && once_more(begin_s));
    if (code == 0) return fd;
    // Nobody listens: the simulator has ended, and its nodes with it.
    const int reason = errno == ECONNREFUSED ? ENOENT : errno;
    (void)close(fd);
    return fail(reason);
}

/// As recv; a signal to the program does not end it.
static ssize_t receive_patiently(int fd, void* out, size_t n_out) {
    const time_t begin_s = now_s();
    ssize_t n;
    do n = recv(fd, out, n_out, 0);
    while (n < 0 && once_more(begin_s));
    return n;
}

/// As sendmsg, the same; a message is sent whole or not at all.
static ssize_t send_patiently(int fd, const struct msghdr* message) {
    const time_t begin_s = now_s();
    ssize_t n;
    do n = sendmsg(fd, message, MSG_NOSIGNAL);
    while (n < 0 && once_more(begin_s));
    return n;
}

/// Sends the hello with the two descriptors and takes the welcome.
static int greet(int fd, const int handed[2], pal_wire_welcome* welcome) {
    pal_wire_hello hello = {PAL_WIRE_VERSION};
    struct iovec bytes = {&hello, sizeof hello};
    union {
        char room[CMSG_SPACE(2 * sizeof(int))];
        struct cmsghdr align;
    } control;
    memset(&control, 0, sizeof control);
    struct msghdr message = {
        .msg_iov = &bytes, .msg_iovlen = 1, .msg_control = &control, .msg_controllen = sizeof control};
    struct cmsghdr* rights = CMSG_FIRSTHDR(&message);
    rights->cmsg_level = SOL_SOCKET;
    rights->cmsg_type = SCM_RIGHTS;
    rights->cmsg_len = CMSG_LEN(2 * sizeof(int));
    memcpy(CMSG_DATA(rights), handed, 2 * sizeof(int));
    if (send_patiently(fd, &message) != (ssize_t)sizeof hello) return fail(ENODEV);
    if (receive_patiently(fd, welcome, sizeof *welcome) != (ssize_t)sizeof *welcome) return fail(ENODEV);
    return welcome->error == 0 ? 0 : fail(welcome->error);
}

/// A pipe that is full with one byte, and is full.
static int open_pipe(int ends[2], int flags) {
    if (pipe2(ends, O_CLOEXEC | O_NONBLOCK) != 0) return -1;
    const bool one_page = fcntl(ends[1], F_SETPIPE_SZ, PIPE_BYTES_MIN) == sysconf(_SC_PAGESIZE);
    if (one_page && (flags & O_CLOEXEC) == 0) (void)fcntl(ends[1], F_SETFD, 0);
    if (one_page && write(ends[1], "", 1) == 1) return 0;
    (void)close(ends[0]);
    (void)close(ends[1]);
    return fail(EMFILE);
}

static int connect_link(pal_preload_link* link, const char* path, int flags) {
    int ends[2];
    int calls[2];
    link->urbs = pal_preload_connect(path);
    if (link->urbs < 0) return -1;
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, calls) == 0) {
        if (open_pipe(ends, flags) == 0) {
            pal_wire_welcome welcome;
            const int handed[2] = {ends[0], calls[1]};
            const int greeted = greet(link->urbs, handed, &welcome);
            const int reason = errno;
            (void)close(ends[0]);
            (void)close(calls[1]);
            if (greeted == 0) {
                const struct timeval patience = {PAL_WIRE_PATIENCE_S, 0};
                (void)setsockopt(calls[0], SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
                link->fd = ends[1];
                link->calls = calls[0];
                link->out_endpoints = welcome.out_endpoints;
                link->in_endpoints = welcome.in_endpoints;
                return 0;
            }
            (void)close(ends[1]);
            (void)close(calls[0]);
            errno = reason;
        } else {
            (void)close(calls[0]);
            (void)close(calls[1]);
        }
    }
    const int reason = errno;
    (void)close(link->urbs);
    return fail(reason);
}

int pal_preload_link_open(const char* path, const char* node, int flags) {
    pal_preload_link* link = calloc(1, sizeof *link);
    if (!link) return fail(ENOMEM);
    (void)pthread_mutex_init(&link->urb_mutex, NULL);
    (void)pthread_mutex_init(&link->reap_mutex, NULL);
    (void)pthread_mutex_init(&link->call_mutex, NULL);
    link->next_tag = 1;
    const size_t n_node = strlen(node);
    memcpy(link->node, node, n_node < sizeof link->node ? n_node : sizeof link->node - 1);
    if (connect_link(link, path, flags) != 0) {
        const int reason = errno;
        free(link);
        return fail(reason);
    }
    if (link->fd < FDS_MAX) {
        __atomic_store_n(&g_links[link->fd], link, __ATOMIC_RELEASE);
        return link->fd;
    }
    (void)close(link->fd);
    (void)close(link->urbs);
    (void)close(link->calls);
    free(link);
    return fail(EMFILE);
}

void pal_preload_link_close(int fd) {
    if (!pal_preload_link_of(fd) || !pal_preload_owns_memory()) return;
    pal_preload_link* link = __atomic_exchange_n(&g_links[fd], NULL, __ATOMIC_ACQ_REL);
    if (!link) return;
    (void)close(link->urbs);
    (void)close(link->calls);
    free(link);
}

void pal_preload_link_close_range(unsigned first, unsigned last) {
    for (unsigned fd = first; fd <= last && fd < FDS_MAX; ++fd) pal_preload_link_close((int)fd);
}

/// The read end is closed: unplugged, or the simulator has ended. True for ever once it was true.
static bool is_gone(const pal_preload_link* link) {
    struct pollfd node = {.fd = link->fd};
    return poll(&node, 1, 0) > 0 && (node.revents & (POLLERR | POLLNVAL)) != 0;
}

static uint64_t remember(pal_preload_link* link, struct usbdevfs_urb* urb) {
    uint64_t tag = 0;
    (void)pthread_mutex_lock(&link->urb_mutex);
    for (int tried = 0; tried < URBS_MAX && tag == 0; ++tried, ++link->next_tag) {
        pending* place = &link->pending[link->next_tag % URBS_MAX];
        if (place->urb) continue;
        tag = link->next_tag;
        *place = (pending){urb, tag};
    }
    (void)pthread_mutex_unlock(&link->urb_mutex);
    return tag;
}

static struct usbdevfs_urb* forget(pal_preload_link* link, uint64_t tag) {
    struct usbdevfs_urb* urb = NULL;
    (void)pthread_mutex_lock(&link->urb_mutex);
    pending* place = &link->pending[tag % URBS_MAX];
    if (place->urb && place->tag == tag) {
        urb = place->urb;
        place->urb = NULL;
    }
    (void)pthread_mutex_unlock(&link->urb_mutex);
    return urb;
}

static uint64_t tag_of(pal_preload_link* link, const struct usbdevfs_urb* urb) {
    uint64_t tag = 0;
    (void)pthread_mutex_lock(&link->urb_mutex);
    for (int i = 0; i < URBS_MAX && tag == 0; ++i) {
        if (link->pending[i].urb == urb) tag = link->pending[i].tag;
    }
    (void)pthread_mutex_unlock(&link->urb_mutex);
    return tag;
}

/// 0, or why usbfs would not take it.
static int describe(const pal_preload_link* link, const struct usbdevfs_urb* urb, pal_wire_urb* out,
                    struct iovec* data) {
    const bool control = urb->type == USBDEVFS_URB_TYPE_CONTROL;
    if (!control && urb->type != USBDEVFS_URB_TYPE_BULK && urb->type != USBDEVFS_URB_TYPE_INTERRUPT)
        return EINVAL;
    if (urb->buffer_length < (control ? SETUP_BYTES : 0)) return EINVAL;
    uint8_t* bytes = urb->buffer;
    uint32_t n = (uint32_t)urb->buffer_length;
    bool in = (urb->endpoint & ENDPOINT_IN) != 0;
    if (control) {
        memcpy(out->setup, bytes, SETUP_BYTES);
        in = (out->setup[0] & ENDPOINT_IN) != 0;
        const uint32_t wanted = (uint32_t)out->setup[6] | (uint32_t)out->setup[7] << 8;
        bytes += SETUP_BYTES;
        n -= SETUP_BYTES;
        if (wanted > n) return EINVAL;
        n = wanted;
    } else {
        const unsigned known = in ? link->in_endpoints : link->out_endpoints;
        if ((known >> (urb->endpoint & 0x0FU) & 1U) == 0) return ENOENT;
    }
    if (n > PAL_WIRE_DATA_MAX) return ENOMEM;
    out->kind = PAL_WIRE_SUBMIT;
    out->endpoint = control ? 0 : urb->endpoint;
    out->short_is_error = (urb->flags & USBDEVFS_URB_SHORT_NOT_OK) != 0;
    out->n_bytes = n;
    *data = (struct iovec){bytes, in ? 0 : n};
    return 0;
}

int pal_preload_submit(pal_preload_link* link, struct usbdevfs_urb* urb) {
    pal_wire_urb head = {0};
    struct iovec parts[2] = {{&head, sizeof head}, {NULL, 0}};
    const int refused = describe(link, urb, &head, &parts[1]);
    if (refused != 0) return fail(refused);
    urb->status = -EINPROGRESS;
    urb->actual_length = 0;
    head.tag = remember(link, urb);
    if (head.tag == 0) return fail(ENOMEM);
    const struct msghdr message = {.msg_iov = parts, .msg_iovlen = 2};
    const bool sent = send_patiently(link->urbs, &message) >= 0;
    // A program that has once seen the error on its descriptor never looks there again. So from then on no
    // URB may be taken, even if the socket still lives for a moment (a process that is killed closes them one
    // by one).
    if (sent && !is_gone(link)) return 0;
    return forget(link, head.tag) ? fail(ENODEV) : 0;  // not ours any more: it was reaped meanwhile
}

int pal_preload_discard(pal_preload_link* link, const struct usbdevfs_urb* urb) {
    pal_wire_urb head = {.kind = PAL_WIRE_DISCARD, .tag = tag_of(link, urb)};
    struct iovec bytes = {&head, sizeof head};
    const struct msghdr message = {.msg_iov = &bytes, .msg_iovlen = 1};
    if (head.tag == 0) return fail(EINVAL);
    if (send_patiently(link->urbs, &message) < 0 || is_gone(link)) return fail(ENODEV);
    return 0;
}

/// Makes the descriptor say "nothing to reap". The signal of a broken pipe is kept from the program.
static void fill_pipe(const pal_preload_link* link) {
    sigset_t broken;
    sigset_t before;
    sigset_t waiting;
    (void)sigemptyset(&broken);
    (void)sigaddset(&broken, SIGPIPE);
    (void)sigpending(&waiting);
    (void)pthread_sigmask(SIG_BLOCK, &broken, &before);
    if (write(link->fd, "", 1) < 0 && errno == EPIPE && sigismember(&waiting, SIGPIPE) == 0) {
        const struct timespec at_once = {0, 0};
        (void)sigtimedwait(&broken, NULL, &at_once);
    }
    (void)pthread_sigmask(SIG_SETMASK, &before, NULL);
}

/// The next message into link->message. Its length, 0: none now, -1: never again.
static ssize_t receive(pal_preload_link* link) {
    for (int tries = 0; tries < 4; ++tries) {  // an error may stand before messages that still came
        const ssize_t n = recv(link->urbs, link->message, sizeof link->message, MSG_DONTWAIT);
        if (n > 0) return n;
        if (n == 0) return -1;
        if (errno == EAGAIN) return 0;
    }
    return -1;
}

/// What one message says about its URB; NULL when that is none of ours any more.
static struct usbdevfs_urb* complete(pal_preload_link* link, size_t n) {
    pal_wire_urb head;
    if (n < sizeof head) return NULL;
    memcpy(&head, link->message, sizeof head);
    struct usbdevfs_urb* urb = head.kind == PAL_WIRE_DONE ? forget(link, head.tag) : NULL;
    if (!urb) return NULL;
    const bool control = urb->type == USBDEVFS_URB_TYPE_CONTROL;
    const int offset = control ? SETUP_BYTES : 0;
    const size_t room = (size_t)(urb->buffer_length - offset);
    const size_t n_data = n - sizeof head < room ? n - sizeof head : room;
    if (n_data > 0) memcpy((uint8_t*)urb->buffer + offset, link->message + sizeof head, n_data);
    urb->status = head.status;
    urb->actual_length = (int)(head.n_bytes < room ? head.n_bytes : room);
    urb->error_count = 0;
    return urb;
}

int pal_preload_reap(pal_preload_link* link, struct usbdevfs_urb** urb, bool wait) {
    bool filled = false;
    (void)pthread_mutex_lock(&link->reap_mutex);
    int code = 0;
    for (*urb = NULL; !*urb && code == 0;) {
        const ssize_t n = receive(link);
        if (n > 0) {
            *urb = complete(link, (size_t)n);
        } else if (n < 0) {
            code = ENODEV;
        } else if (wait) {
            struct pollfd news = {.fd = link->urbs, .events = POLLIN};
            if (poll(&news, 1, -1) < 0) code = errno;
        } else if (filled) {
            code = EAGAIN;
        } else {
            fill_pipe(link);  // what came before this is seen by the next look, what comes after it empties
                              // the pipe
            filled = true;
        }
    }
    (void)pthread_mutex_unlock(&link->reap_mutex);
    return code == 0 ? 0 : fail(code);
}

int pal_preload_call(pal_preload_link* link, pal_wire_call_kind kind, uint32_t argument) {
    pal_wire_call call = {kind, argument};
    struct iovec bytes = {&call, sizeof call};
    const struct msghdr message = {.msg_iov = &bytes, .msg_iovlen = 1};
    int32_t answer = -ENODEV;
    (void)pthread_mutex_lock(&link->call_mutex);
    if (is_gone(link) || send_patiently(link->calls, &message) < 0 ||
        receive_patiently(link->calls, &answer, sizeof answer) != (ssize_t)sizeof answer) {
        answer = -ENODEV;
        (void)shutdown(link->calls, SHUT_RDWR);  // a late answer must not be taken for that of the next call
    }
    (void)pthread_mutex_unlock(&link->call_mutex);
    return answer >= 0 ? answer : fail(-answer);
}

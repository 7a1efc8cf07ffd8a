#include "sim/app/help.h"

// In parts: no C compiler need take a longer string than 4095 bytes.
static const char USES[] =
    "palpate-falcon-sim: a simulated Novint Falcon in real time, held by a simulated hand.\n"
    "\n"
    "For any program that uses libusb-1.0 (no hardware, no root, no USB in the kernel):\n"
    "  palpate-falcon-sim run [options] -- PROGRAM [arguments]   the program sees the device; its exit code "
    "is passed on\n"
    "  palpate-falcon-sim serve --usb [options]                  be the device until quit, SIGTERM or Ctrl-C "
    "...\n"
    "  eval \"$(palpate-falcon-sim env)\"                          ... and let another terminal's programs "
    "see it\n"
    "  palpate-falcon-sim status | heal | quit [--bus FOLDER]    one line of JSON; end all faults; end it\n"
    "  palpate-falcon-sim fault \"unplug at_s=0 for_s=0.5\"        a fault now, or at_s seconds from now\n"
    "  palpate-falcon-sim press 4                                hold grip buttons: 1 right, 2 front, 4 "
    "middle, 8 left\n"
    "  all but run and serve ask the one of --bus FOLDER, else of $PALPATE_FALCON_BUS, else of "
    "/tmp/palpate-falcon-UID\n"
    "\n"
    "For a machine with USB in its kernel, over TCP:\n"
    "  palpate-falcon-sim usbip [options]                        then there: usbip attach -r HOST -b 1-1\n"
    "\n"
    "For palpate-loop, packets alone:\n"
    "  palpate-falcon-sim serve --socket PATH [options]   be the device until quit or SIGTERM\n"
    "  palpate-falcon-sim status --socket PATH            print one line of JSON: motors, position, state\n"
    "  palpate-falcon-sim quit --socket PATH              end the one that serves PATH\n"
    "\n";

static const char MECHANICS[] =
    "The hand and the mechanics (run, serve, usbip):\n"
    "  --path FILE         where the hand goes: \"palpate-path 1\", then lines \"t_us x_um y_um z_um\" "
    "(device frame);\n"
    "                      without it the hand homes the device and holds it at the middle\n"
    "  --grip NAME         none, light, firm, or MASS,STIFFNESS,DAMPING in kg, N/m, N s/m; light\n"
    "                      without stiffness a helper homes the device and lets go when the path begins\n"
    "  --ramp-ticks N      milliseconds between homing and the path's start, for the loop's soft start and "
    "the way there;\n"
    "                      give palpate-loop the same; 1000\n"
    "  --seed N            of all that is random; what the counters read before homing; 1\n"
    "  --watchdog-ms N     motors off after so long without a packet; 100\n"
    "  --scale X           another delta: all lengths X times a Falcon's, 0.25..4; a driver needs the same "
    "geometry,\n"
    "                      palpate-falcon and palpate-loop by --delta FILE; a path is not scaled; 1\n"
    "\n";

static const char DEVICE[] =
    "The device on USB (run, serve --usb, usbip):\n"
    "  --timing NAME       frames: 1 ms USB frames and true times, as a real one; immediate: answers at "
    "once; frames\n"
    "  --packets-per-frame N  for each endpoint, 1..19; 1\n"
    "  --devices N         so many Falcons, 1..8, serials counting up; 1\n"
    "  --serial TEXT       of the first one\n"
    "  --faults FILE       what goes wrong and when, a line each: \"unplug at_s=2 for_s=0.1\" "
    "(docs/PROTOCOL.md)\n"
    "  --pcap FILE         all USB transfers as a usbmon capture, for Wireshark\n"
    "  --bus FOLDER        where it is served; run: a new one in /tmp; else $PALPATE_FALCON_BUS or "
    "/tmp/palpate-falcon-UID\n"
    "  --device N          of fault: only the Nth; all\n"
    "\n"
    "What nobody knows of a real one (run, serve --usb, usbip):\n"
    "  --running              its firmware runs already, as after an earlier session\n"
    "  --zero-before-answer   a byte 00 comes before the first boot answer\n"
    "  --xoff-before-echo     a byte 13 comes before the echo of 'A'\n"
    "  --autobaud-fail P      probability that 'A' is not locked on above 100000 baud\n"
    "  --unplug-keeps-firmware  the DSP lives on its own supply\n"
    "  --modem-lines HEX      status lines: 10 CTS, 20 DSR, 40 RI, 80 DCD\n"
    "  --home-deg ANGLE       arm angle of the homing reference; -15\n"
    "\n";

static const char REST[] =
    "Of serve --socket:\n"
    "  --socket PATH       Unix SOCK_SEQPACKET socket: 16 bytes in, 16 bytes out, as a Falcon's "
    "(docs/PROTOCOL.md)\n"
    "                      questions go to PATH.control: \"status\" and \"quit\"\n"
    "  --linger-s N        with --die-with-parent: so many seconds more, in which it can still be asked; 5\n"
    "Of usbip:\n"
    "  --listen ADDRESS    IPv4; 127.0.0.1\n"
    "  --port N            TCP; 0: a free one; 3240\n"
    "Of serve and usbip:\n"
    "  --die-with-parent   end when the process that started this one has ended\n"
    "\n"
    "Exit codes: 0 done, 2 bad input, 3 the simulator cannot serve or is not there; of run: the program's.\n"
    "\n"
    "Example:\n"
    "  palpate-falcon-sim run --grip firm -- lsusb -d 0403:cb48\n"
    "  palpate-falcon-sim serve --socket /tmp/falcon --grip firm &\n"
    "  palpate-falcon-sim status --socket /tmp/falcon\n";

int pal_help(FILE* out) {
    const char* const parts[] = {USES, MECHANICS, DEVICE, REST};
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; ++i) {
        if (fputs(parts[i], out) < 0) return 1;
    }
    return 0;
}

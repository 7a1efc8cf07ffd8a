// The exporter speaks USB/IP 1.1.1: to the usbip tool, and byte for byte.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cstring>
#include <string>

#include "tests/sim/usb/capture.hpp"
#include "tests/sim/usb/process.hpp"

using Catch::Contains;
using namespace usbtest;

namespace {

/// usbip on a free port, ready.
class Exporter {
public:
    explicit Exporter(const std::string& timing = "immediate", const std::vector<std::string>& more = {})
        : process_([&timing, &more] {
              std::vector<std::string> argv{kProgram,     "usbip",    "--port",   "0",        "--bus",
                                            bus_folder(), "--serial", "PAL12345", "--timing", timing};
              argv.insert(argv.end(), more.begin(), more.end());
              return argv;
          }()) {
        REQUIRE(process_.read_until("sudo"));
    }
    Exporter(const Exporter&) = delete;
    Exporter& operator=(const Exporter&) = delete;
    ~Exporter() {
        process_.send(SIGKILL);
        (void)process_.wait();
        std::filesystem::remove_all(bus_folder());
    }
    std::string port() {
        const std::string words = simulator({"status", "--bus", bus_folder()}).words;
        REQUIRE_THAT(words, Contains("PAL12345"));
        return port_of(process_);
    }
    Process& process() { return process_; }

private:
    static std::string port_of(Process& process) {
        const std::string& words = process.so_far();
        const std::string before = "TCP port ";
        const auto at = words.find(before) + before.size();
        return words.substr(at, words.find('\n', at) - at);
    }
    Process process_;
};

class Peer {
public:
    explicit Peer(const std::string& port) : fd_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
        sockaddr_in where{};
        where.sin_family = AF_INET;
        where.sin_port = htons(static_cast<uint16_t>(std::stoi(port)));
        where.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        const timeval patience{10, 0};
        setsockopt(fd_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
        REQUIRE(connect(fd_, reinterpret_cast<const sockaddr*>(&where), sizeof where) == 0);
    }
    Peer(const Peer&) = delete;
    Peer& operator=(const Peer&) = delete;
    ~Peer() { close(fd_); }
    void send(const std::string& bytes) const {
        REQUIRE(::send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size()));
    }
    /// Exactly so many bytes, or fewer when the other end hung up.
    [[nodiscard]] std::string receive(size_t n) const {
        std::string bytes(n, '\0');
        const ssize_t got = recv(fd_, bytes.data(), n, MSG_WAITALL);
        bytes.resize(got > 0 ? static_cast<size_t>(got) : 0);
        return bytes;
    }
    /// Reads on until the other end hangs up; false when it does not within 10 s.
    [[nodiscard]] bool is_hung_up_on() const {
        char byte = 0;
        ssize_t n = 1;
        while (n > 0) n = recv(fd_, &byte, 1, 0);
        return n == 0 || errno == ECONNRESET;
    }

private:
    int fd_;
};

std::string hex(const std::string& digits) {
    std::string bytes;
    for (size_t i = 0; i < digits.size();) {
        if (digits[i] == ' ') {
            ++i;
            continue;
        }
        bytes.push_back(static_cast<char>(std::stoi(digits.substr(i, 2), nullptr, 16)));
        i += 2;
    }
    return bytes;
}

std::string padded(std::string text, size_t n) {
    text.resize(n, '\0');
    return text;
}

/// The record of device 1-1, interface not included.
std::string record() {
    return padded("/sys/devices/palpate/usb1/1-1", 256) + padded("1-1", 32) +
           hex("00000001 00000002 00000002 0403 cb48 0600 00 00 00 01 01 01");
}

/// USBIP_CMD_SUBMIT: sequence, direction (1 in), endpoint, length, setup.
std::string submit(const std::string& sequence, const std::string& direction, const std::string& endpoint,
                   const std::string& n, const std::string& setup = "0000000000000000") {
    return hex("00000001" + sequence + "00010002" + direction + endpoint + "00000000" + n +
               "00000000 00000000 00000000" + setup);
}

std::string returned(const std::string& sequence, const std::string& status, const std::string& n) {
    return hex("00000003" + sequence + "00000000 00000000 00000000" + status + n +
               "00000000 00000000 00000000 0000000000000000");
}

const std::string kImport = hex("0111 8003 00000000") + padded("1-1", 32);

TEST_CASE("usbip list shows the Falcon", "[process]") {
    Exporter exporter;
    const Outcome list = call({PAL_USBIP, "--tcp-port", exporter.port(), "list", "-r", "127.0.0.1"});
    CHECK(list.code == 0);
    CHECK_THAT(list.words, Contains("1-1:") && Contains("(0403:cb48)"));
}

TEST_CASE("list, import, control, bulk and unlink, byte for byte", "[process]") {
    Exporter exporter;
    const std::string port = exporter.port();
    {
        const Peer asker(port);
        asker.send(hex("0111 8005 00000000"));
        CHECK(asker.receive(8 + 4 + 312 + 4) ==
              hex("0111 0005 00000000 00000001") + record() + hex("ff ff ff 00"));
        CHECK(asker.is_hung_up_on());
    }
    const Peer peer(port);
    peer.send(kImport);
    CHECK(peer.receive(8 + 312) == hex("0111 0003 00000000") + record());
    {
        const Peer rival(port);
        rival.send(kImport);
        CHECK(rival.receive(8) == hex("0111 0003 00000002"));  // busy
        const Peer stray(port);
        stray.send(hex("0111 8003 00000000") + padded("9-9", 32));
        CHECK(stray.receive(8) == hex("0111 0003 00000004"));  // no such device
    }
    // GET_DESCRIPTOR device, 18 bytes.
    peer.send(submit("00000001", "00000001", "00000000", "00000012", "8006000100001200"));
    CHECK(peer.receive(48 + 18) == returned("00000001", "00000000", "00000012") +
                                       hex("12 01 00 02 00 00 00 08 03 04 48 cb 00 06 01 02 03 01"));
    // A vendor request that there is not: EPIPE, -32.
    peer.send(submit("00000002", "00000000", "00000000", "00000000", "4066000000000000"));
    CHECK(peer.receive(48) == returned("00000002", "ffffffe0", "00000000"));
    // Boot handshake: 9600 baud, DTR high, then LF 'C' CR; the answer may come in pieces.
    peer.send(submit("00000003", "00000000", "00000000", "00000000", "4003384100000000"));
    peer.send(submit("00000004", "00000000", "00000000", "00000000", "4001010100000000"));
    peer.send(submit("00000005", "00000000", "00000002", "00000003") + "\nC\r");
    CHECK(peer.receive(3 * 48) == returned("00000003", "00000000", "00000000") +
                                      returned("00000004", "00000000", "00000000") +
                                      returned("00000005", "00000000", "00000003"));
    std::string answer;
    for (int i = 0; i < 100 && answer.size() < 4; ++i) {
        peer.send(submit("00000006", "00000001", "00000001", "00000040"));
        const std::string head = peer.receive(48);
        REQUIRE(head.size() == 48);
        const auto n = static_cast<size_t>(static_cast<unsigned char>(head[27]));
        CHECK(head == returned("00000006", "00000000",
                               "000000" + std::string(n < 16 ? "0" : "") +
                                   std::string(1, "0123456789abcdef"[n % 16])));
        answer += peer.receive(n).substr(2);
    }
    CHECK(answer == "\nD,\r");
    // A read that waits 255 ms for its status, unlinked before: ECONNRESET, -104, and no answer of its own.
    // All in one piece, so that they meet the device in one moment.
    peer.send(submit("00000007", "00000000", "00000000", "00000000", "4009ff0000000000") +
              submit("00000008", "00000001", "00000001", "00000040") +
              hex("00000002 00000009 00010002 00000000 00000000 00000008") + std::string(24, '\0'));
    const std::string set = peer.receive(48);
    CHECK(set == returned("00000007", "00000000", "00000000"));
    CHECK(peer.receive(48) ==
          hex("00000004 00000009 00000000 00000000 00000000 ffffff98") + std::string(24, '\0'));
    // Once more: there is nothing left to unlink.
    peer.send(hex("00000002 0000000a 00010002 00000000 00000000 00000008") + std::string(24, '\0'));
    CHECK(peer.receive(48) ==
          hex("00000004 0000000a 00000000 00000000 00000000 00000000") + std::string(24, '\0'));
}

TEST_CASE("the importer's hanging up frees the device, an unplug hangs up on the importer", "[process]") {
    Exporter exporter;
    const std::string port = exporter.port();
    for (int i = 0; i < 20; ++i) {
        const Peer peer(port);
        std::string head;
        do {  // the exporter may not have seen yet that the one before is gone
            const Peer next(port);
            next.send(kImport);
            head = next.receive(8);
        } while (head == hex("0111 0003 00000002"));
        CHECK(head == hex("0111 0003 00000000"));
    }
    std::string head;
    for (;;) {
        const Peer peer(port);
        peer.send(kImport);
        head = peer.receive(8);
        if (head == hex("0111 0003 00000002")) continue;
        CHECK(peer.receive(312) == record());
        CHECK(simulator({"fault", "unplug at_s=0 for_s=1000", "--bus", bus_folder()}).code == 0);
        CHECK(peer.is_hung_up_on());
        break;
    }
    const Peer late(port);
    late.send(kImport);
    CHECK(late.receive(8) == hex("0111 0003 00000004"));
}

TEST_CASE("bytes that are no USB/IP are hung up on", "[process]") {
    Exporter exporter;
    const std::string port = exporter.port();
    const std::string nonsense =
        GENERATE(as<std::string>{}, "GET / HTTP/1.0\r\n\r\n", std::string("\x01\x11\x80\x77\0\0\0\0", 8));
    const Peer peer(port);
    peer.send(nonsense);
    CHECK(peer.is_hung_up_on());
    const Peer next(port);
    next.send(hex("0111 8005 00000000"));
    CHECK(next.receive(12) == hex("0111 0005 00000000 00000001"));
}

TEST_CASE("an importer with more in flight than there is room for is hung up on, and the next is served",
          "[process]") {
    Exporter exporter("frames");
    const std::string port = exporter.port();
    {
        const Peer peer(port);
        peer.send(kImport);
        REQUIRE(peer.receive(8 + 312).size() == 320);
        std::string reads;
        for (int i = 0; i < 17; ++i) reads += submit("00000001", "00000001", "00000001", "00100000");
        peer.send(reads);  // 17 MB
        CHECK(peer.is_hung_up_on());
    }
    const Peer next(port);
    next.send(kImport);
    CHECK(next.receive(8 + 312).size() == 320);
}

TEST_CASE("a capture of an export has what the peer sent, and how it ended", "[process]") {
    const std::string file = bus_folder() + ".pcap";
    {
        Exporter exporter("immediate", {"--pcap", file});
        const Peer peer(exporter.port());
        peer.send(kImport);
        REQUIRE(peer.receive(8 + 312).size() == 320);
        peer.send(submit("00000001", "00000001", "00000000", "00000012", "8006000100001200"));
        REQUIRE(peer.receive(48 + 18).size() == 66);
        peer.send(submit("00000002", "00000001", "00000000", "00000001", "4066000000000100"));
        static_cast<void>(peer.receive(48));
        exporter.process().send(SIGTERM);
        CHECK(exporter.process().wait() == 0);
    }
    const Capture capture(file);
    std::filesystem::remove(file);
    CHECK(capture.pair() == 0);
    const auto& records = capture.records();
    REQUIRE(records.size() == 12 + 4);
    CHECK(records[12].setup == hex("8006000100001200"));
    CHECK(records[13].data.size() == 18);
    CHECK(records[14].setup == hex("4066000000000100"));
    CHECK(records[15].status == -32);
}

}  // namespace

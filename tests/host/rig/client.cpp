#include "tests/host/rig/client.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <sstream>
#include <stdexcept>

namespace palpate::rig::test {

Bytes hex(const std::string& text) {
    std::istringstream in(text);
    Bytes bytes;
    for (std::string word; in >> word;)
        bytes.push_back(static_cast<std::uint8_t>(std::stoul(word, nullptr, 16)));
    return bytes;
}

Bytes operator+(Bytes a, const Bytes& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

Client::Client(std::uint16_t port) : fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(fd_.get(), reinterpret_cast<const sockaddr*>(&to), sizeof to) != 0) {
        throw std::runtime_error("cannot connect to the server under test");
    }
}

bool Client::send(const Bytes& bytes) {
    std::size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t n = ::send(fd_.get(), bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
        if (n <= 0) return false;
        done += static_cast<std::size_t>(n);
    }
    return true;
}

bool Client::receive_into(std::uint8_t* bytes, std::size_t n_bytes) {
    return n_bytes == 0 || ::recv(fd_.get(), bytes, n_bytes, MSG_WAITALL) == static_cast<ssize_t>(n_bytes);
}

Bytes Client::receive() {
    constexpr std::size_t HEAD_BYTES = 6;
    Bytes answer(HEAD_BYTES);
    if (!receive_into(answer.data(), HEAD_BYTES)) return {};
    const auto n_rest = static_cast<std::size_t>(answer[4] << 8 | answer[5]);
    answer.resize(HEAD_BYTES + n_rest);
    if (!receive_into(answer.data() + HEAD_BYTES, n_rest)) return {};
    return answer;
}

Bytes Client::ask(const Bytes& request) {
    return send(request) ? receive() : Bytes{};
}

}  // namespace palpate::rig::test

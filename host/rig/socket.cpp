#include "host/rig/socket.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <charconv>

#include "host/rig/rig.hpp"

namespace palpate::rig {

Endpoint loopback_endpoint(const std::string& address) {
    const std::string quoted = "'" + address + "'";
    const std::size_t colon = address.rfind(':');
    if (colon == std::string::npos) {
        throw Error(quoted + " is not ADDR:PORT; 127.0.0.1:1502 would be right");
    }
    Endpoint endpoint{.ip = address.substr(0, colon)};
    const char* const first = address.data() + colon + 1;
    const char* const last = address.data() + address.size();
    const auto [end, problem] = std::from_chars(first, last, endpoint.port);
    if (problem != std::errc{} || end != last) {
        throw Error(quoted + " has no port from 0 to 65535 behind the colon; 127.0.0.1:1502 would be right");
    }
    if (endpoint.ip == "localhost") endpoint.ip = "127.0.0.1";
    in_addr ip{};
    if (::inet_pton(AF_INET, endpoint.ip.c_str(), &ip) != 1 ||
        ntohl(ip.s_addr) >> IN_CLASSA_NSHIFT != IN_LOOPBACKNET) {
        throw Error(quoted +
                    " is not a loopback address (127.0.0.0/8, localhost); Modbus has no password, so no "
                    "other is served");
    }
    return endpoint;
}

}  // namespace palpate::rig

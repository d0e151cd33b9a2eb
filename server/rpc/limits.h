// Limits of the network skin.
#pragma once

namespace isthmus::rpc {

// Seconds between looks at the files of certificates: a robot that comes in the second after a
// renewal may see the old one, which is valid still.
inline constexpr unsigned kCertificateReloadS = 1;

}  // namespace isthmus::rpc

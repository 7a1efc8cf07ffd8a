/// Ctrl-C and SIGTERM, once noticed, stay noticed.
#pragma once

namespace palpate::app {

/// From now on SIGINT and SIGTERM set a flag instead of ending the process; a second one ends it.
void catch_interrupts();
[[nodiscard]] bool interrupted();

}  // namespace palpate::app

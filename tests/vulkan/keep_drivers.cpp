// SPDX-License-Identifier: Apache-2.0
// Under LeakSanitizer: drivers stay where they are. Mesa's keep memory in variables of their own until the process ends, which
// counts as lost when Vulkan's loader has unloaded the driver before, under no name that lsan.supp could know.
extern "C" int dlclose(void*) { return 0; }

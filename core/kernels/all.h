// SPDX-License-Identifier: Apache-2.0
// Every kernel file, in the order in which they depend on each other.

// For `tsc --checkJs` only: types of three.js, which the check fetches from npm.
export * from "three";

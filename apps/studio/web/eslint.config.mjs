// The rules of the page's code beyond its types. Layout is Prettier's.
import js from "@eslint/js";
import { defineConfig } from "eslint/config";
import { dirname } from "node:path";
import { fileURLToPath } from "node:url";
import tseslint from "typescript-eslint";

const camelCase = { format: ["camelCase"], leadingUnderscore: "forbid", trailingUnderscore: "forbid" };

export default defineConfig(
  { ignores: ["dist", "node_modules"] },
  js.configs.recommended,
  tseslint.configs.recommended,
  {
    linterOptions: { reportUnusedDisableDirectives: "error" },
    rules: {
      // Properties may have the names of the protocol, of a package or of a shader.
      "@typescript-eslint/naming-convention": [
        "error",
        { selector: ["variable", "parameter", "classMethod", "classProperty", "accessor"], ...camelCase },
        { selector: "function", format: ["camelCase", "PascalCase"] }, // components
        { selector: ["variable", "parameter"], modifiers: ["destructured"], format: ["camelCase", "PascalCase"] }, // classes
        { selector: "parameter", modifiers: ["unused"], format: ["camelCase"], leadingUnderscore: "allow" },
        { selector: "variable", filter: "^cogrsim_bundle$", format: null }, // the program writes it into a bundle
        { selector: "typeLike", format: ["PascalCase"] },
      ],
      "@typescript-eslint/no-unused-vars": ["error", { argsIgnorePattern: "^_", ignoreRestSiblings: true }],
      eqeqeq: "error",
      "no-self-compare": "error",
      "object-shorthand": "error",
      "prefer-template": "error",
    },
  },
  {
    files: ["src/**/*.ts", "src/**/*.tsx"],
    languageOptions: {
      parserOptions: { projectService: true, tsconfigRootDir: dirname(fileURLToPath(import.meta.url)) },
    },
    rules: {
      "@typescript-eslint/consistent-type-imports": ["error", { fixStyle: "inline-type-imports" }],
      "@typescript-eslint/no-floating-promises": [
        "error",
        { allowForKnownSafeCalls: [{ from: "package", package: "node:test", name: "test" }] },
      ],
      "@typescript-eslint/no-misused-promises": "error",
      "@typescript-eslint/no-unnecessary-type-assertion": "error",
      "@typescript-eslint/switch-exhaustiveness-check": ["error", { considerDefaultExhaustiveForUnions: true }],
    },
  },
  {
    files: ["*.mjs"],
    languageOptions: { globals: { console: "readonly", process: "readonly" } },
  },
);
